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
#include "vdblic/render/render_plan.h"
#include "view/line_packet.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace vdblic::view {
namespace {

using Json = nlohmann::json;

/// Time without a new frame after which automatic choices follow the frames that came.
constexpr std::chrono::seconds kPause{5};

/// All that loadFrame() depends on besides the file.
std::string loadKey(const PicturePlan& plan)
{
    const glm::dvec3& stretch = plan.stretch;
    const std::string region = plan.regionBox ? fmt::format("{}", fmt::join(*plan.regionBox, " ")) : std::string();
    return fmt::format("{}|{}|{} {} {}|{}|{}|{}", plan.colorBy, fmt::join(plan.opacityBy, ","), stretch.x, stretch.y,
                       stretch.z, plan.look.shading.model == ShadingModel::kLine, plan.look.transfer.sharesRange(),
                       region);
}

std::string cacheKey(const PicturePlan& plan, const FrameFile& file)
{
    const std::string lines = plan.lines.empty() ? "" : fileStamp(linesFile(plan, file.frame));
    return fmt::format("{}|{}|{}|{}", file.frame, fileStamp(file.path), lines, loadKey(plan));
}

/// A state without camera and sampling.
std::string choiceKey(Json state)
{
    for (const char* name : {"eye", "target", "up", "fov", "view-height", "projection", "size", "samples", "step",
                             "orbit", "orbit-frames", "keys"})
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

ViewSource sourceOf(const SequenceParams& input, const PicturePlan& plan)
{
    auto source = viewSource(input, plan);
    if (!source) (void)loadFrame(plan, selectFrames(input).front()); // throws if there is no texture
    if (!source) throw InputError(fmt::format("{}: no frame has an active voxel", input.pattern));
    return *source;
}

/// The files of lines in voxels that are on disk.
std::vector<FileSeen> lineFiles(const Start& start)
{
    const auto lines = start.fixed.find("lines");
    return lines == start.fixed.end() ? std::vector<FileSeen>() : filesOnDisk({.pattern = lines->second.front()});
}

} // namespace

Viewer::Viewer(Start start, double cacheBytes) : mStart(std::move(start)), mCache(cacheBytes)
{
    SequenceTraits& traits = mStart.traits;
    const std::vector<FrameFile> files = selectFrames(mStart.input);
    traits.texture = textureName(files.front().path, planOf(mStart, mStart.state).texture);
    for (const auto& grid : readVdbHeader(files.front().path).grids) {
        mHasLines |= grid->isType<openvdb::points::PointDataGrid>() && grid->getName() == traits.texture;
        if (grid->isType<openvdb::FloatGrid>() && grid->getName() != traits.texture)
            traits.scalars.push_back(grid->getName());
    }
    mFiles = filesOnDisk(mStart.input);
    const PicturePlan plan = planOf(mStart, Json::object());
    mSource = sourceOf(mStart.input, plan);
    checkLines(plan, mSource.lookFrames.front());
    mLineFiles = lineFiles(mStart);
}

std::vector<std::int64_t> Viewer::frames()
{
    std::vector<FileSeen> found, lines;
    try {
        found = filesOnDisk(mStart.input);
        lines = lineFiles(mStart);
    } catch (const Error&) { // the folder was removed
    }
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mMutex);
    if (!found.empty() && (found != mFiles || lines != mLineFiles)) {
        mFiles = std::move(found);
        mLineFiles = std::move(lines);
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
    const ViewSource found = sourceOf(mStart.input, planOf(mStart, Json::object()));
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

ViewSource Viewer::source(const glm::dvec3& stretch)
{
    const std::lock_guard lock(mMutex);
    ViewSource result = mSource;
    for (glm::dvec3& corner : result.box)
        corner *= stretch;
    return result;
}

FrameFile Viewer::fileOf(std::int64_t frame)
{
    const std::lock_guard lock(mMutex);
    if (std::ranges::find(mFiles, frame, &FileSeen::frame) == mFiles.end())
        throw ParameterError(fmt::format("the sequence has no frame {}", frame));
    return {frame, FramePattern(mStart.input.pattern).path(frame)};
}

FrameCache::Frame Viewer::load(const PicturePlan& plan, const FrameFile& file)
{
    return mCache.get(cacheKey(plan, file), [&] { return loadFrame(plan, file); });
}

/// Of a frame that the cache cannot hold, the finest coarser copy that it can hold, or else the coarsest one.
std::optional<FrameFile> Viewer::coarserCopy(const PicturePlan& plan, const FrameFile& file) const
{
    const std::vector<FrameFile> copies = coarserCopies(mStart.input, file);
    if (copies.empty()) return std::nullopt;
    std::optional<FrameFile> found;
    double bytes = frameBytes(plan, file);
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
    const PicturePlan plan = planOf(mStart, mStart.state);
    const double bytes = frameBytes(plan, first), most = mCache.most();
    if (bytes <= most || coarserCopy(plan, first)) return {};
    const int levels = int(std::ceil(std::log2(bytes / most) / 3)); // each an eighth of the one before
    const std::string& pattern = mStart.input.pattern;
    return fmt::format(
        "a frame takes {}, more than the {} that are for frames, so its first picture waits until it is read. "
        "Coarser copies would be shown at once; they are made by: {}",
        memoryText(bytes), memoryText(most),
        shellCommand({"vdblic_export", pattern, "-o", pattern, "--levels", fmt::to_string(levels)}));
}

/// The frame, or of one that is not loaded yet a coarser copy.
FrameCache::Frame Viewer::loadSoon(const PicturePlan& plan, const FrameFile& file)
{
    if (FrameCache::Frame known = mCache.find(cacheKey(plan, file))) return known;
    const std::optional<FrameFile> copy = coarserCopy(plan, file);
    if (copy) paging::makeRoom(frameBytes(plan, file) + mCache.most()); // the frame follows, beside the cached ones
    return load(plan, copy.value_or(file));
}

void Viewer::keepBasis(const std::string& key, const std::shared_ptr<const Basis>& basis)
{
    const std::lock_guard lock(mMutex);
    const bool replaces = std::ranges::any_of(mBases, [&](const auto& entry) { return entry.first == key; });
    keepFirst(mBases, key, basis, kMostBases);
    if (replaces) ++mVersion;
}

std::shared_ptr<const Viewer::Basis> Viewer::basisFor(const PicturePlan& plan, bool settle)
{
    const std::string key = loadKey(plan);
    {
        const std::lock_guard lock(mMutex);
        for (const auto& [other, basis] : mBases) {
            if (other == key && (basis->settled || !settle)) return basis;
        }
    }
    if (settle) return settledBasis(plan);
    const ViewSource known = source(plan.stretch);
    const FrameCache::Frame first = loadSoon(plan, known.lookFrames.front());
    if (first->empty()) return settledBasis(plan);
    auto basis = std::make_shared<Basis>();
    OneProcess alone;
    basis->look.add(*first, alone);
    basis->frames = {first->file};
    basis->settled = known.lookFrames.size() == 1 && first->file.path == known.lookFrames.front().path;
    keepBasis(key, basis);
    return basis;
}

void Viewer::settleLater(const FrameView& view)
{
    mBackground.add([this, plan = view.plan, frame = view.shown->frame().file.frame] {
        (void)basisFor(plan, /*settle=*/true);
        const FrameFile file = fileOf(frame);
        if (mCache.find(cacheKey(plan, file)) || !coarserCopy(plan, file)) return;
        (void)load(plan, file);
        const std::lock_guard lock(mMutex);
        ++mVersion;
    });
}

std::shared_ptr<const Viewer::Basis> Viewer::settledBasis(const PicturePlan& plan)
{
    auto basis = std::make_shared<Basis>();
    OneProcess alone;
    const ViewSource known = source(plan.stretch);
    for (const FrameFile& file : known.lookFrames) {
        try {
            const FrameCache::Frame frame = load(plan, file);
            if (frame->empty()) continue;
            basis->look.add(*frame, alone);
            basis->frames.push_back(file);
        } catch (const InputError&) { // is reported at the frame's turn
            if (file.frame == known.lookFrames.front().frame) throw;
        }
    }
    if (basis->frames.empty()) throw InputError(fmt::format("{}: no frame has an active voxel", mStart.input.pattern));
    basis->settled = true;
    keepBasis(loadKey(plan), basis);
    return basis;
}

Viewer::Choice Viewer::choiceFor(const PicturePlan& plan, const Json& state, const std::shared_ptr<const Basis>& basis,
                                 const ViewSource& source)
{
    const bool needsSubject = !(plan.camera.eye && plan.camera.projection == Projection::kPerspective);
    const std::string key = choiceKey(state);
    {
        const std::lock_guard lock(mMutex);
        for (const auto& [other, found] : mChoices) {
            const auto& [of, choice] = found;
            if (other == key && of == basis && (choice.hasSubject || !needsSubject)) return choice;
        }
    }
    std::vector<FrameCache::Frame> frames;
    if (needsSubject || !plan.lines.empty()) {
        for (const FrameFile& file : basis->frames) {
            try {
                frames.push_back(load(plan, file));
            } catch (const InputError&) { // removed, or being replaced
                if (frames.empty() && file.frame == basis->frames.back().frame) throw;
            }
        }
    }
    Choice choice{chooseLooks(plan, basis->look, frames), {}, needsSubject};
    if (needsSubject) {
        const auto& [look, lines] = choice.looks;
        OneProcess alone;
        choice.subject = subjectOf(plan, look, frames, source.box, mSolids, alone, lines ? &lines->look : nullptr);
    }
    const std::lock_guard lock(mMutex);
    keepFirst(mChoices, key, std::pair(basis, choice), kMostChoices);
    return choice;
}

/// The frame with a look, for all cameras.
std::shared_ptr<const ShownVolume> Viewer::shownFor(const PicturePlan& plan, const Json& state, const Looks& looks,
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
    auto shown = std::make_shared<const ShownVolume>(plan, looks.voxels, frame, mSolids.of(plan, *frame), alone,
                                                     looks.lines ? &looks.lines->look : nullptr);
    const std::lock_guard lock(mMutex);
    mShown = {key, basis, shown};
    return shown;
}

FrameView Viewer::view(const Json& state, std::int64_t frame, bool settle)
{
    const PicturePlan plan = planOf(mStart, state);
    const FrameFile file = fileOf(frame);
    const ViewSource known = source(plan.stretch);
    const auto basis = basisFor(plan, settle);
    const Choice choice = choiceFor(plan, state, basis, known);
    const CameraPath cameras(plan.camera, plan.motion, known.box, plan.size, known.span, choice.subject);
    const double bytes = basis->look.volumeBytes + plan.imageBytes();
    const FrameCache::Frame loaded = settle ? load(plan, file) : loadSoon(plan, file);
    return {plan,
            View{choice.looks.voxels, basis->look.opacityBy, cameras, known.box, bytes, basis->look.lastFrame,
                 basis->look.longest, choice.looks.lines},
            shownFor(plan, state, choice.looks, loaded, basis), basis->settled && loaded->file.path == file.path};
}

Camera Viewer::fitted(Json state, const glm::dvec3& forward, const glm::dvec3& up)
{
    if (!(glm::length(glm::cross(forward, up)) > 1e-9 * glm::length(forward) * glm::length(up)))
        throw ParameterError("a view needs a direction, and another one that is up");
    for (const char* name : {"eye", "target", "up", "view-height", "orbit", "orbit-frames", "keys"})
        state.erase(name);
    const PicturePlan plan = planOf(mStart, state);
    const ViewSource known = source(plan.stretch);
    const Choice choice = choiceFor(plan, state, basisFor(plan, false), known);
    const glm::ivec2 size = plan.size;
    const Camera automatic(plan.camera, known.box, size, choice.subject);
    const glm::dvec3 direction = glm::normalize(forward), middle = middleOf(known.box);
    const std::span<const glm::dvec3> points =
        choice.subject.empty() ? std::span<const glm::dvec3>(known.box) : choice.subject;
    const Framing framing =
        frameTightly(automatic.projection(), viewAxes(direction, up), points, automatic.halfExtent());
    CameraParams camera = plan.camera;
    camera.eye = framing.eye;
    camera.target = framing.eye + direction * glm::dot(direction, middle - framing.eye);
    camera.up = up;
    if (camera.projection == Projection::kOrthographic) camera.viewHeight = 2 * framing.halfExtent.y;
    return {camera, known.box, size};
}

void Viewer::prefetch(const Json& state, std::int64_t frame)
{
    mBackground.add([this, plan = planOf(mStart, state), file = fileOf(frame)] { (void)loadSoon(plan, file); });
}

std::string Viewer::lines(const Json& state, std::int64_t frame)
{
    constexpr std::size_t kMostPoints = 1'000'000; // 16 MB
    const PicturePlan plan = planOf(mStart, state);
    const FrameCache::Frame loaded = load(plan, fileOf(frame));
    return loaded->tubes ? linePacket(*loaded->tubes, source(plan.stretch).box, kMostPoints) : "";
}

TextureHistograms Viewer::histograms(const Json& state)
{
    const PicturePlan plan = planOf(mStart, state);
    const auto basis = basisFor(plan, false);
    const VolumeSamples& samples = basis->look.samples;
    TextureHistograms result(choiceFor(plan, state, basis, source(plan.stretch)).looks.voxels);
    for (const float value : samples.texture)
        result.texture.add(double(value));
    for (const float value : samples.color.empty() ? samples.driver : samples.color)
        result.color.add(double(value));
    for (const float value : samples.driver)
        result.opacity.add(double(value));
    return result;
}

} // namespace vdblic::view
