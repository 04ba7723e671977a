#include "vdblic/render/view.h"

#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/ground_plane.h"
#include "vdblic/cast/shown_tubes.h"
#include "vdblic/cast/solid.h"
#include "vdblic/cast/tube_extent.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/extent.h"
#include "vdblic/render/annotations.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/sequence_bounds.h"
#include "vdblic/render/solid_maker.h"
#include "vdblic/volume/leaf_share.h"
#include "vdblic/volume/visible_extent.h"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <utility>

namespace vdblic {

void LookBasis::add(const LoadedTexture& frame, Exchange& exchange)
{
    frame.tubes ? addTubes(*frame.tubes) : addVolume(*frame.volume, frame.isSparse, exchange);
    volumeBytes = std::max(volumeBytes, frame.bytes());
    lastFrame = std::max(lastFrame, frame.file.frame);
    longest = std::max(longest, std::abs(frame.clock.time.value_or(0)));
    if (!first.empty()) return;
    first = frame.file.path;
    opacityBy = frame.opacityBy;
    kinds = frame.kinds;
}

void LookBasis::addVolume(const TextureVolume& volume, bool isSparse, Exchange& exchange)
{
    VolumeSamples more = volume.samples();
    more = {exchange.join(more.texture), exchange.join(more.driver), exchange.join(more.color)};
    samples.append(more);
    const auto active = double(volume.domain().voxelCount());
    openvdb::CoordBBox box;
    volume.domain().topology().evalActiveVoxelBoundingBox(box);
    // Of a sparse texture a ray meets its share of the box.
    const double share = isSparse ? active / voxelsOf(box) : 1;
    constexpr double kOblique = 2; // how much longer a path through a plate may be than the plate is thick
    const std::array<std::int64_t, 3> extent = extentOf(box);
    const double narrowest = share * double(*std::min_element(extent.begin(), extent.end()));
    thickness = std::max(thickness, std::min(std::cbrt(active * share * share), kOblique * narrowest));
}

void LookBasis::addTubes(const Tubes& tubes)
{
    samples.append(tubes.samples());
    thickness = std::max(thickness, tubes.crossings());
    ofLines = true;
}

Look LookBasis::choose(const PicturePlan& plan) const
{
    try {
        constexpr double kCrisp = 4; // times the optical depth of voxels, except where lines of no kind hide the others
        LookParams open = plan.look;
        open.transfer.kinds = kinds;
        Look look = chooseLook(open, samples, ofLines && kinds.empty() ? thickness / kCrisp : thickness, ofLines);
        look.background = plan.background;
        return look;
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", first.string(), error.what()));
    }
}

namespace {

/// Points around the solids of the frames. @throws InputError if no camera can show one and the volume in a box
std::vector<glm::dvec3> solidPoints(const PicturePlan& plan,
                                    std::span<const std::shared_ptr<const LoadedTexture>> frames, const Corners& box,
                                    SolidMaker& solids)
{
    constexpr double kMost = 1e6; // diagonals of the box
    std::vector<glm::dvec3> points;
    for (const auto& frame :
         frames.first(solidChanges(plan.solid) ? frames.size() : std::min<std::size_t>(1, frames.size()))) {
        try {
            const auto more = solidExtent(*solids.of(plan, *frame));
            points.insert(points.end(), more.begin(), more.end());
        } catch (const InputError&) { // is reported at the frame's turn
        }
    }
    for (const glm::dvec3& point : points) {
        const double away = glm::length(point - box[0]) / glm::length(box[7] - box[0]);
        if (!(away > kMost)) continue;
        throw InputError(fmt::format("{}: the solid reaches {:.3g} times as far as the texture: cut it, or check its "
                                     "transform",
                                     plan.solid, away));
    }
    return points;
}

/// World-space points around the visible part of a frame.
std::vector<glm::dvec3> visiblePoints(const LoadedTexture& frame, const Look& look, const ClipParams& clip,
                                      Exchange& exchange)
{
    if (frame.volume) return visibleExtent(*frame.volume, look, clip, exchange);
    return visibleExtent(*frame.tubes, ExtinctionGrid(ShownTubes(*frame.tubes, look)), clip);
}

/// Add the points of the ground that lie below the points of a subject, where most of its shadow falls.
void addOnGround(const PicturePlan& plan, const Corners& box, std::vector<glm::dvec3>& subject)
{
    const glm::dvec3 up = plan.camera.up.value_or(glm::dvec3(0, 0, 1));
    const GroundPlane plane = groundPlane(plan.ground, up, box, nullptr);
    for (std::size_t i = 0, count = subject.size(); i < count; ++i)
        subject.push_back(subject[i] + plane.normal * (plane.height - glm::dot(subject[i], plane.normal)));
}

} // namespace

Looks chooseLooks(const PicturePlan& plan, const LookBasis& basis,
                  std::span<const std::shared_ptr<const LoadedTexture>> frames)
{
    Looks looks{basis.choose(plan)};
    LookBasis ofLines;
    OneProcess alone; // each rank has all lines
    bool isColored = true;
    for (const auto& frame : frames) {
        if (frame->lines && !frame->lines->empty()) ofLines.add(*frame->lines, alone);
        isColored = isColored && frame->hasColor;
    }
    if (ofLines.first.empty()) return looks;
    PicturePlan lines = planOfLines(plan);
    if (isColored && !plan.look.transfer.range) {
        const auto &a = looks.voxels.transfer.range(), b = ofLines.choose(lines).transfer.range();
        PicturePlan both = plan;
        both.look.transfer.range = {std::min(a[0], b[0]), std::max(a[1], b[1])};
        looks.voxels = basis.choose(both);
    }
    if (isColored) lines.look.transfer.range = looks.voxels.transfer.range();
    looks.lines = View::OfLines{ofLines.choose(lines), ofLines.opacityBy};
    return looks;
}

std::vector<glm::dvec3> subjectOf(const PicturePlan& plan, const Look& look,
                                  std::span<const std::shared_ptr<const LoadedTexture>> frames, const Corners& box,
                                  SolidMaker& solids, Exchange& exchange, const Look* lines)
{
    std::vector<glm::dvec3> subject;
    if (plan.camera.eye && plan.camera.projection == Projection::kPerspective) return subject;
    const AnnotationParams& annotations = plan.annotations;
    if (annotations.box || annotations.axes) {
        subject.assign(box.begin(), box.end());
    } else {
        if (!plan.solid.empty()) subject = solidPoints(plan, frames, box, solids);
        for (const auto& frame : frames) {
            const auto more = visiblePoints(*frame, look, plan.rays.clip.stretched(plan.stretch), exchange);
            subject.insert(subject.end(), more.begin(), more.end());
            if (!frame->lines || !lines) continue;
            const auto ofLines = visiblePoints(*frame->lines, *lines, plan.rays.clip.stretched(plan.stretch), exchange);
            subject.insert(subject.end(), ofLines.begin(), ofLines.end());
        }
        if (plan.ground != GroundSide::kNone) addOnGround(plan, box, subject);
    }
    if (!annotations.axes && !annotations.colorBar) return subject;
    const Camera view(plan.camera, box, plan.size, subject);
    return withRoom(std::move(subject), annotations, view);
}

View chooseView(const PicturePlan& plan, std::span<const std::shared_ptr<const LoadedTexture>> frames,
                const Corners& box, const FrameSpan& span, Exchange& exchange)
{
    LookBasis basis;
    for (const auto& frame : frames)
        basis.add(*frame, exchange);
    auto [look, lines] = chooseLooks(plan, basis, frames);
    auto solids = std::make_shared<SolidMaker>();
    std::vector<glm::dvec3> subject =
        subjectOf(plan, look, frames, box, *solids, exchange, lines ? &lines->look : nullptr);
    const CameraPath cameras(plan.camera, plan.motion, box, plan.size, span, std::move(subject));
    return {std::move(look),
            basis.opacityBy,
            cameras,
            box,
            basis.volumeBytes + plan.imageBytes(),
            basis.lastFrame,
            basis.longest,
            std::move(lines),
            std::move(solids)};
}

namespace {

/// A rank's part of a frame; nullopt for a single process.
std::optional<BoxShare> boxOf(const FrameFile& file, const std::string& grid, const Exchange& exchange)
{
    if (exchange.isAlone()) return std::nullopt;
    const std::optional<GridHeader> header = textureHeader(file, grid);
    return BoxShare(header ? header->box : openvdb::CoordBBox(), exchange.rank(), exchange.size());
}

} // namespace

std::optional<ViewSource> viewSource(const SequenceParams& input, const PicturePlan& plan)
{
    const FramePattern pattern(input.pattern);
    std::vector<FrameFile> files;
    FrameSpan span;
    if (pattern.hasField()) {
        for (const std::int64_t frame : pattern.framesOnDisk())
            files.push_back({frame, pattern.path(frame)});
        span.first = files.front().frame;
        span.length = files.back().frame - files.front().frame + frameSpacing(input);
    } else {
        files = selectFrames(input);
    }
    std::optional<SequenceBounds> bounds = sequenceBounds(files, plan.texture);
    if (!bounds) return std::nullopt;
    for (glm::dvec3& corner : bounds->box)
        corner *= plan.stretch;
    constexpr std::size_t kLookFrames = 4;
    const std::size_t count = files.size();
    FrameFile first = bounds->firstFilled;
    if (!plan.lines.empty()) { // of frames that have lines, if there is one
        const auto isThere = [&](const FrameFile& file) {
            return std::filesystem::exists(linesFile(plan, file.frame));
        };
        if (const auto found = std::ranges::find_if(files, isThere); found != files.end() && !isThere(first))
            first = *found;
        if (isThere(first)) std::erase_if(files, std::not_fn(isThere));
    }
    std::vector<FrameFile> lookFrames{first};
    for (std::size_t i = 1; i < std::min(kLookFrames, files.size()); ++i) {
        const FrameFile& file = files[i * (files.size() - 1) / (std::min(kLookFrames, files.size()) - 1)];
        if (file.frame != first.frame) lookFrames.push_back(file);
    }
    return ViewSource{count, span, bounds->box, std::move(lookFrames)};
}

std::optional<SequenceView> viewOfSequence(const RenderPlan& plan, Exchange& exchange)
{
    const std::optional<ViewSource> source = viewSource(plan.input, plan.picture);
    if (!source) return std::nullopt;
    std::vector<std::shared_ptr<const LoadedTexture>> frames;
    PicturePlan rest = plan.picture; // opacity follows the grid of the first frame in all others
    for (const FrameFile& file : source->lookFrames) {
        const bool first = file.frame == source->lookFrames.front().frame;
        try {
            std::shared_ptr<const LoadedTexture> loaded;
            exchange.together([&] {
                const std::optional<BoxShare> share = boxOf(file, plan.picture.texture, exchange);
                loaded =
                    std::make_shared<const LoadedTexture>(loadFrame(rest, file, nullptr, share ? &*share : nullptr));
            });
            frames.push_back(std::move(loaded));
            if (!rest.opacityBy.empty()) rest.opacityBy = {frames.front()->opacityBy};
        } catch (const InputError&) { // is reported at the frame's turn
            if (first && !plan.keepGoing) throw;
        }
    }
    std::erase_if(frames, [](const auto& frame) { return frame->empty(); });
    if (frames.empty()) return std::nullopt;
    SequenceView result{chooseView(plan.picture, frames, source->box, source->span, exchange), nullptr};
    if (source->frameCount == 1 && exchange.isAlone()) result.onlyFrame = frames.front();
    return result;
}

} // namespace vdblic
