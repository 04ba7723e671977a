#include "view/viewer.h"

#include "vdblic/camera/framing.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/io/file_stamp.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_header.h"
#include "vdblic/render/frames_in_flight.h"
#include "vdblic/render/render_params.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace vdblic::view {
namespace {

using Json = nlohmann::json;

/// Time without a new frame after which automatic choices follow the frames that came.
constexpr std::chrono::seconds kPause{5};

/// What loadFrame() depends on besides the file.
std::string loadKey(const RenderParams& params)
{
    const glm::dvec3& stretch = params.stretch;
    const std::string region = params.regionBox ? fmt::format("{}", fmt::join(*params.regionBox, " ")) : std::string();
    return fmt::format("{}|{}|{} {} {}|{}|{}|{}", params.colorBy, fmt::join(params.opacityBy, ","), stretch.x,
                       stretch.y, stretch.z, params.look.shading.model == ShadingModel::kLine,
                       params.look.transfer.sharesRange(), region);
}

std::string cacheKey(const RenderParams& params, const FrameFile& file)
{
    return fmt::format("{}|{}|{}", file.frame, fileStamp(file.path), loadKey(params));
}

/// A state without what its camera and sampling are.
std::string choiceKey(Json state)
{
    for (const char* name : {"eye", "target", "up", "fov", "view-height", "projection", "size", "scale", "samples",
                             "step", "orbit", "orbit-frames", "keys"})
        state.erase(name);
    return state.dump();
}

constexpr std::size_t kMostBases = 8, kMostChoices = 32; // of small pictures, too

/// Put an entry in front and keep the first few.
template<typename List, typename Value>
void keepFirst(List& list, const std::string& key, Value value, std::size_t most)
{
    list.remove_if([&](const auto& entry) { return entry.first == key; });
    list.emplace_front(key, std::move(value));
    if (list.size() > most) list.pop_back();
}

SceneSource sourceOf(const RenderParams& params)
{
    auto source = sceneSource(params);
    if (!source) throw InputError(fmt::format("{}: no frame has an active voxel", params.input.pattern));
    return *source;
}

} // namespace

Viewer::Viewer(Start start, double cacheBytes) : mStart(std::move(start)), mCache(cacheBytes)
{
    RenderParams params = paramsOf(mStart, mStart.state);
    const std::vector<FrameFile> files = selectFrames(mStart.input);
    mTexture = textureName(files.front().path, params.texture);
    for (const auto& grid : readVdbHeader(files.front().path).grids) {
        if (grid->isType<openvdb::FloatGrid>() && grid->getName() != mTexture) mScalars.push_back(grid->getName());
    }
    mFiles = filesOnDisk(mStart.input);
    params.texture = mTexture;
    params.stretch = glm::dvec3(1);
    mSource = sourceOf(params);
}

std::vector<std::int64_t> Viewer::frames()
{
    std::vector<FileSeen> found;
    try {
        found = filesOnDisk(mStart.input);
    } catch (const Error&) { // the folder was taken away
    }
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mMutex);
    if (!found.empty() && found != mFiles) {
        mFiles = std::move(found);
        mChanged = now;
        mSourceIsOld = true;
        ++mVersion;
    } else if (mSourceIsOld && now - mChanged > kPause) {
        mChanged = now;
        mBackground.add([this] { readSource(); });
    }
    std::vector<std::int64_t> frames;
    for (const FileSeen& file : mFiles)
        frames.push_back(file.frame);
    return frames;
}

void Viewer::readSource()
{
    RenderParams params = paramsOf(mStart, Json::object());
    params.texture = mTexture;
    const SceneSource found = sourceOf(params);
    const std::lock_guard lock(mMutex);
    mSource = found;
    mSourceIsOld = false;
    mBases.clear();
    mChoices.clear();
    ++mVersion;
}

std::uint64_t Viewer::version()
{
    const std::lock_guard lock(mMutex);
    return mVersion;
}

SceneSource Viewer::source(const glm::dvec3& stretch)
{
    const std::lock_guard lock(mMutex);
    SceneSource result = mSource;
    for (glm::dvec3& corner : result.box)
        corner *= stretch;
    return result;
}

RenderParams Viewer::paramsFor(const Json& state) const
{
    RenderParams params = paramsOf(mStart, state);
    params.texture = mTexture;
    const auto known =
        std::find_first_of(params.opacityBy.begin(), params.opacityBy.end(), mScalars.begin(), mScalars.end());
    if (known != params.opacityBy.end()) params.opacityBy = {std::string(*known)};
    return params;
}

FrameFile Viewer::fileOf(std::int64_t frame)
{
    const std::lock_guard lock(mMutex);
    if (std::ranges::find(mFiles, frame, &FileSeen::frame) == mFiles.end())
        throw ParameterError(fmt::format("the sequence has no frame {}", frame));
    return {frame, FramePattern(mStart.input.pattern).path(frame)};
}

FrameCache::Frame Viewer::load(const RenderParams& params, const FrameFile& file)
{
    return mCache.get(cacheKey(params, file), [&] { return loadFrame(params, file); });
}

/// Of a frame that the cache cannot hold, the finest coarser copy that it can hold, or else the coarsest one.
std::optional<FrameFile> Viewer::coarserCopy(const RenderParams& params, const FrameFile& file) const
{
    const std::vector<FrameFile> copies = coarserCopies(mStart.input, file);
    if (copies.empty()) return std::nullopt;
    std::optional<FrameFile> found;
    double bytes = frameBytes(params, file);
    for (const FrameFile& copy : copies) {
        if (bytes <= mCache.most()) break;
        found = copy;
        bytes /= 8;
    }
    return found;
}

std::string Viewer::advice() const
{
    const FrameFile first = selectFrames(mStart.input).front();
    const RenderParams params = paramsFor(mStart.state);
    const double bytes = frameBytes(params, first), most = mCache.most();
    if (bytes <= most || coarserCopy(params, first)) return {};
    const int levels = int(std::ceil(std::log2(bytes / most) / 3)); // each an eighth of the one before
    const std::string& pattern = mStart.input.pattern;
    return fmt::format(
        "a frame takes {}, more than the {} that are for frames, so its first picture waits until it is read. "
        "Coarser copies would be shown at once; they are made by: {}",
        memoryText(bytes), memoryText(most),
        shellCommand({"vdblic_export", pattern, "-o", pattern, "--levels", fmt::to_string(levels)}));
}

/// The frame, or of one that is not loaded yet a coarser copy.
FrameCache::Frame Viewer::loadSoon(const RenderParams& params, const FrameFile& file)
{
    if (FrameCache::Frame known = mCache.find(cacheKey(params, file))) return known;
    const std::optional<FrameFile> copy = coarserCopy(params, file);
    if (copy) paging::makeRoom(frameBytes(params, file) + mCache.most()); // the frame follows, beside what is there
    return load(params, copy.value_or(file));
}

void Viewer::keepBasis(const std::string& key, const std::shared_ptr<const Basis>& basis)
{
    const std::lock_guard lock(mMutex);
    const bool replaces = std::ranges::any_of(mBases, [&](const auto& entry) { return entry.first == key; });
    keepFirst(mBases, key, basis, kMostBases);
    if (replaces) ++mVersion;
}

std::shared_ptr<const Viewer::Basis> Viewer::basisFor(const RenderParams& params, bool settle)
{
    const std::string key = loadKey(params);
    {
        const std::lock_guard lock(mMutex);
        for (const auto& [other, basis] : mBases) {
            if (other == key && (basis->settled || !settle)) return basis;
        }
    }
    if (settle) return settledBasis(params);
    const SceneSource known = source(params.stretch);
    const FrameCache::Frame first = loadSoon(params, known.lookFrames.front());
    if (first->volume.empty()) return settledBasis(params);
    auto basis = std::make_shared<Basis>();
    OneProcess alone;
    basis->look.add(*first, alone);
    basis->frames = {first->file};
    basis->settled = known.lookFrames.size() == 1 && first->file.path == known.lookFrames.front().path;
    keepBasis(key, basis);
    return basis;
}

void Viewer::settleLater(const View& view)
{
    mBackground.add([this, params = view.params, frame = view.shown->frame().file.frame] {
        (void)basisFor(params, /*settle=*/true);
        const FrameFile file = fileOf(frame);
        if (mCache.find(cacheKey(params, file)) || !coarserCopy(params, file)) return;
        (void)load(params, file);
        const std::lock_guard lock(mMutex);
        ++mVersion;
    });
}

std::shared_ptr<const Viewer::Basis> Viewer::settledBasis(const RenderParams& params)
{
    auto basis = std::make_shared<Basis>();
    OneProcess alone;
    const SceneSource known = source(params.stretch);
    for (const FrameFile& file : known.lookFrames) {
        try {
            const FrameCache::Frame frame = load(params, file);
            if (frame->volume.empty()) continue;
            basis->look.add(*frame, alone);
            basis->frames.push_back(file);
        } catch (const InputError&) { // is reported at the frame's turn
            if (file.frame == known.lookFrames.front().frame) throw;
        }
    }
    if (basis->frames.empty()) throw InputError(fmt::format("{}: no frame has an active voxel", mStart.input.pattern));
    basis->settled = true;
    keepBasis(loadKey(params), basis);
    return basis;
}

Viewer::Choice Viewer::choiceFor(const RenderParams& params, const Json& state,
                                 const std::shared_ptr<const Basis>& basis, const SceneSource& source)
{
    const bool needsSubject = !(params.camera.eye && params.camera.projection == Projection::kPerspective);
    const std::string key = choiceKey(state);
    {
        const std::lock_guard lock(mMutex);
        for (const auto& [other, found] : mChoices) {
            const auto& [of, choice] = found;
            if (other == key && of == basis && (choice.hasSubject || !needsSubject)) return choice;
        }
    }
    Choice choice{basis->look.choose(params), {}, needsSubject};
    if (needsSubject) {
        std::vector<FrameCache::Frame> frames;
        for (const FrameFile& file : basis->frames) {
            try {
                frames.push_back(load(params, file));
            } catch (const InputError&) { // taken away, or being replaced
                if (frames.empty() && file.frame == basis->frames.back().frame) throw;
            }
        }
        OneProcess alone;
        choice.subject = sceneSubject(params, choice.look, frames, source.box, alone);
    }
    const std::lock_guard lock(mMutex);
    keepFirst(mChoices, key, std::pair(basis, choice), kMostChoices);
    return choice;
}

std::shared_ptr<const Solid> Viewer::solidFor(const RenderParams& params, const LoadedTexture& frame)
{
    const SolidParams& solid = params.solid;
    if (solid.source.empty()) return nullptr;
    const std::string key = fmt::format("{}|{} {} {}|{}|{}", solid.source, params.stretch.x, params.stretch.y,
                                        params.stretch.z, solid.changes() ? frame.file.frame : 0,
                                        frame.texture->voxelSize()[0]); // of a coarser copy another one
    {
        const std::lock_guard lock(mMutex);
        if (mSolid.first == key) return mSolid.second;
    }
    auto made = std::make_shared<const Solid>(makeSolid(solid, *frame.domain(), params.stretch, frame.file.frame));
    const std::lock_guard lock(mMutex);
    mSolid = {key, made};
    return made;
}

/// The frame with a look, for all cameras.
std::shared_ptr<const ShownFrame> Viewer::shownFor(const RenderParams& params, const Json& state, const Look& look,
                                                   const FrameCache::Frame& frame,
                                                   const std::shared_ptr<const Basis>& basis)
{
    const std::string key = choiceKey(state);
    {
        const std::lock_guard lock(mMutex);
        const bool isSame = mShown.frame && &mShown.frame->frame() == frame.get();
        if (isSame && mShown.key == key && mShown.basis == basis) return mShown.frame;
    }
    OneProcess alone;
    auto shown = std::make_shared<const ShownFrame>(params, look, frame, solidFor(params, *frame), alone);
    const std::lock_guard lock(mMutex);
    mShown = {key, basis, shown};
    return shown;
}

View Viewer::view(const Json& state, std::int64_t frame, bool settle)
{
    const RenderParams params = paramsFor(state);
    const FrameFile file = fileOf(frame);
    const SceneSource known = source(params.stretch);
    const auto basis = basisFor(params, settle);
    const Choice choice = choiceFor(params, state, basis, known);
    const CameraPath cameras(params.camera, params.motion, known.box, params.scaledSize(), known.span, choice.subject);
    const double bytes = basis->look.volumeBytes + params.imageBytes();
    const FrameCache::Frame loaded = settle ? load(params, file) : loadSoon(params, file);
    return {params,
            Scene{choice.look, basis->look.opacityBy, cameras, known.box, bytes, basis->look.lastFrame,
                  basis->look.longest},
            shownFor(params, state, choice.look, loaded, basis), basis->settled && loaded->file.path == file.path};
}

Camera Viewer::fitted(Json state, const glm::dvec3& forward, const glm::dvec3& up)
{
    if (!(glm::length(glm::cross(forward, up)) > 1e-9 * glm::length(forward) * glm::length(up)))
        throw ParameterError("a view needs a direction, and another one that is up");
    for (const char* name : {"eye", "target", "up", "view-height", "orbit", "orbit-frames", "keys"})
        state.erase(name);
    const RenderParams params = paramsFor(state);
    const SceneSource known = source(params.stretch);
    const Choice choice = choiceFor(params, state, basisFor(params, false), known);
    const glm::ivec2 size = params.scaledSize();
    const Camera automatic(params.camera, known.box, size, choice.subject);
    const glm::dvec3 direction = glm::normalize(forward), middle = middleOf(known.box);
    const std::span<const glm::dvec3> points =
        choice.subject.empty() ? std::span<const glm::dvec3>(known.box) : choice.subject;
    const Framing framing =
        frameTightly(automatic.projection(), viewAxes(direction, up), points, automatic.halfExtent());
    CameraParams camera = params.camera;
    camera.eye = framing.eye;
    camera.target = framing.eye + direction * glm::dot(direction, middle - framing.eye);
    camera.up = up;
    if (camera.projection == Projection::kOrthographic) camera.viewHeight = 2 * framing.halfExtent.y;
    return {camera, known.box, size};
}

void Viewer::prefetch(const Json& state, std::int64_t frame)
{
    mBackground.add([this, params = paramsFor(state), file = fileOf(frame)] { (void)loadSoon(params, file); });
}

TextureHistograms Viewer::histograms(const Json& state)
{
    const RenderParams params = paramsFor(state);
    const auto basis = basisFor(params, false);
    const VolumeSamples& samples = basis->look.samples;
    TextureHistograms result(choiceFor(params, state, basis, source(params.stretch)).look);
    for (const float value : samples.texture)
        result.texture.add(double(value));
    for (const float value : samples.color.empty() ? samples.driver : samples.color)
        result.color.add(double(value));
    for (const float value : samples.driver)
        result.opacity.add(double(value));
    return result;
}

} // namespace vdblic::view
