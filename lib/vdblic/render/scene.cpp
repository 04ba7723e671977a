#include "vdblic/render/scene.h"

#include "vdblic/cast/ground_plane.h"
#include "vdblic/cast/solid.h"
#include "vdblic/cast/solid_extent.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/extent.h"
#include "vdblic/field/derived_grids.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/field/resample.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/annotations.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/sequence_bounds.h"
#include "vdblic/volume/coarse_scalar.h"
#include "vdblic/volume/leaf_share.h"
#include "vdblic/volume/visible_extent.h"
#include "vdblic/volume/visible_space.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// A scalar grid that a file lacks, and what makes it.
InputError missingScalar(const VdbFile& file, const std::vector<std::string>& names, std::string choice)
{
    const auto made =
        std::find_first_of(names.begin(), names.end(), std::begin(kDerivedNames), std::end(kDerivedNames));
    if (made != names.end()) choice += fmt::format(", or make it with vdblic_advect --with {}", *made);
    return file.missing(fmt::format("float grid '{}'", fmt::join(names, "' or '")), choice);
}

/// The first of a file's float grids with one of these names.
openvdb::FloatGrid::Ptr findScalar(const VdbFile& file, const std::vector<std::string>& names)
{
    for (const std::string& name : names) {
        if (auto grid = file.find<openvdb::FloatGrid>(name)) return grid;
    }
    return nullptr;
}

/// A text of a file's or a grid's metadata; empty if it has none.
std::string textOf(const openvdb::MetaMap& metadata, const char* key)
{
    const auto text = metadata.getMetadata<openvdb::StringMetadata>(key);
    return text ? text->value() : "";
}

FrameClock clockOf(const openvdb::MetaMap& metadata)
{
    return {numericMetadata(metadata, "time"), numericMetadata(metadata, "dt"), textOf(metadata, "start")};
}

/// The unit of a scalar: its metadata `unit`, or that of speeds in the file's unit of length.
std::string unitOf(const openvdb::FloatGrid& scalar, const std::string& lengthUnit)
{
    std::string unit = textOf(scalar, "unit");
    if (!unit.empty() || scalar.getName() != kSpeedGrid || lengthUnit.empty()) return unit;
    return lengthUnit + "/s";
}

/// Names of the values of a scalar that tells the sources of streaks apart; empty for others.
std::vector<std::string> kindsOf(const openvdb::FloatGrid& scalar, const openvdb::MetaMap& metadata)
{
    if (scalar.getName() != kSourceGrid) return {};
    std::vector<std::string> kinds = sourceNames(metadata);
    if (!kinds.empty()) kinds.insert(kinds.begin(), "no source");
    return kinds;
}

/// Of a sparse texture's file, a grid whose active voxels are the flow's. Sources have the streaks' voxels.
/// @param color what colour follows; or null
openvdb::FloatGrid::Ptr flowVoxelsOf(const VdbFile& file, const openvdb::FloatGrid::Ptr& color)
{
    if (color && color->getName() != kSourceGrid) return color;
    return file.find<openvdb::FloatGrid>(kSpeedGrid);
}

openvdb::FloatGrid::Ptr resampledOn(const openvdb::FloatGrid::Ptr& grid, const openvdb::FloatGrid& texture)
{
    const bool together = grid->transform() == texture.transform() || !grid->transform().isLinear();
    return together ? grid : resampled(*grid, texture);
}

/// Voxels around visible leaves whose records are read: lines take those of the next leaf.
int rimOf(const PicturePlan& plan)
{
    return plan.look.shading.model == ShadingModel::kLine ? LeafVoxel::kDim : 0;
}

/// The memory that a leaf of a frame's two grids takes, and the tables of its picture.
constexpr double kLeafBytes =
    2 * (sizeof(openvdb::FloatTree::LeafNodeType::Buffer) + LeafVoxel::kCount * sizeof(float)) +
    double(VisibleSpace::kBytesPerLeaf);

} // namespace

openvdb::FloatGrid::ConstPtr LoadedTexture::domain() const
{
    if (!flowVoxels) return texture;
    constexpr int kFine = 4; // voxels: a level set rounds its edges over about one
    Refinement refinement;
    if (const auto ofTexture = Refinement::between(flowVoxels->transform(), texture->transform())) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            refinement.factors[axis] = std::min(ofTexture->factors[axis], kFine);
    }
    const openvdb::MaskTree voxels(flowVoxels->tree(), false, true, openvdb::TopologyCopy());
    auto finer = openvdb::FloatGrid::create(
        std::make_shared<openvdb::FloatTree>(*refinement.refined(voxels), 0.0f, openvdb::TopologyCopy()));
    finer->setName(flowVoxels->getName());
    finer->setTransform(refinement.refined(flowVoxels->transform()));
    return finer;
}

openvdb::FloatGrid::ConstPtr LoadedTexture::onTexture(const openvdb::FloatGrid::Ptr& scalar) const
{
    try {
        return resampledOn(scalar, *texture);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", file.path.string(), error.what()));
    }
}

double LoadedTexture::bytes() const
{
    return double(volume.leafCount()) * (kLeafBytes + volume.bytesPerLeaf());
}

double bytesPerVoxel(const PicturePlan& plan)
{
    const bool hasLines = plan.look.shading.model == ShadingModel::kLine;
    const int scalars = plan.opacityBy.empty() ? 1 : 2;
    const double records = TextureVolume::bytesPerLeaf(hasLines, scalars * double(ScalarLeaf::kSize * sizeof(float)));
    return (kLeafBytes + records) / LeafVoxel::kCount;
}

LoadedTexture loadFrame(const PicturePlan& plan, const FrameFile& frame, const Scene* scene, const LeafShare* share)
{
    if (!share) return loadFrame(plan, readVdb(frame.path), frame, scene);
    const std::optional<GridHeader> header = textureHeader(frame, plan.texture);
    // Records hold a voxel more on all sides, and their gradients another one. Other grids are to be resampled.
    const int rim = rimOf(plan) + LeafVoxel::kDim;
    const auto isKept = [&](const openvdb::GridBase& grid, const openvdb::Coord& origin) {
        return !header || share->needs(origin, rim) || grid.transform() != *header->transform;
    };
    const bool verifies = share->owns(openvdb::Coord(0)); // one rank does
    const VdbFile file = readVdb(frame.path, isKept, verifies);
    const std::string name = textureName(file.metadata, plan.texture);
    const auto texture = file.find<openvdb::FloatGrid>(name);
    if (header && texture && texture->transform() != *header->transform)
        throw InputError(fmt::format("{}: holds several grids '{}'; rename one", frame.path.string(), name));
    return loadFrame(plan, file, frame, scene, share);
}

LoadedTexture loadFrame(const PicturePlan& plan, const VdbFile& file, const FrameFile& frame, const Scene* scene,
                        const LeafShare* share)
{
    const auto texture = file.get<openvdb::FloatGrid>(textureName(file.metadata, plan.texture), "`texture`");
    std::vector<std::string> opacityBy = plan.opacityBy;
    if (scene && !opacityBy.empty()) opacityBy = {scene->opacityBy};
    const auto storedColor = findScalar(file, {plan.colorBy});
    if (!storedColor && plan.colorBy != kSpeedGrid)
        throw missingScalar(file, {plan.colorBy}, opacityBy.empty() ? "`by`" : "`color_by`");
    const auto storedOpacity = opacityBy.empty() ? storedColor : findScalar(file, opacityBy);
    if (!storedOpacity && !opacityBy.empty()) throw missingScalar(file, opacityBy, "`opacity_by`");
    try {
        const bool isSparse = vdblic::isSparse(file.metadata);
        const auto usable = [&](const openvdb::FloatGrid::Ptr& grid) {
            const bool isCoarse = isSparse && CoarseScalar::of(*grid, *texture);
            return isCoarse ? grid : resampledOn(grid, *texture);
        };
        const auto color = storedColor ? usable(storedColor) : texture;
        const auto opacity = storedOpacity && storedOpacity != storedColor ? usable(storedOpacity) : color;
        const bool hasLines = plan.look.shading.model == ShadingModel::kLine;
        const std::string lengthUnit = textOf(file.metadata, "length_unit");
        // The lines at a leaf's rim are those of its neighbours.
        const RecordUse use{.look = hasLines || !scene ? nullptr : &scene->look,
                            .share = share,
                            .rim = rimOf(plan),
                            .isSparse = isSparse};
        LoadedTexture loaded{frame,
                             texture,
                             color,
                             opacity,
                             bool(storedColor),
                             storedOpacity ? storedOpacity->getName() : plan.colorBy,
                             TextureVolume(*texture, *opacity, plan.stretch, use),
                             clockOf(file.metadata),
                             unitOf(*color, lengthUnit),
                             unitOf(*opacity, lengthUnit),
                             lengthUnit,
                             kindsOf(*color, file.metadata),
                             isSparse,
                             isSparse ? flowVoxelsOf(file, storedColor) : nullptr};
        if (opacity != color || !plan.look.transfer.sharesRange()) loaded.volume.addColors(*texture, *color);
        if (!plan.region.empty() || plan.regionBox) {
            const auto topology = std::make_shared<openvdb::MaskTree>(loaded.volume.domain().topology());
            const DomainParams region{.mask = plan.region, .worldBox = plan.regionBox};
            loaded.volume.cut(*makeDomain(topology, texture->transform(), region, frame.frame).texture);
        }
        if (hasLines) loaded.volume.addLines();
        return loaded;
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", frame.path.string(), error.what()));
    }
}

void LookBasis::add(const LoadedTexture& frame, Exchange& exchange)
{
    VolumeSamples more = frame.volume.samples();
    more = {exchange.join(more.texture), exchange.join(more.driver), exchange.join(more.color)};
    samples.append(more);
    const auto active = double(frame.volume.domain().voxelCount());
    openvdb::CoordBBox box;
    frame.volume.domain().topology().evalActiveVoxelBoundingBox(box);
    // Of a sparse texture a ray meets its share of the box.
    const double share = frame.isSparse ? active / voxelsOf(box) : 1;
    voxels = std::max(voxels, active * share * share);
    const std::array<std::int64_t, 3> extent = extentOf(box);
    narrowest = std::max(narrowest, share * double(*std::min_element(extent.begin(), extent.end())));
    volumeBytes = std::max(volumeBytes, frame.bytes());
    lastFrame = std::max(lastFrame, frame.file.frame);
    longest = std::max(longest, std::abs(frame.clock.time.value_or(0)));
    if (!first.empty()) return;
    first = frame.file.path;
    opacityBy = frame.opacityBy;
    kinds = frame.kinds;
}

Look LookBasis::choose(const PicturePlan& plan) const
{
    try {
        constexpr double kOblique = 2; // how much longer a path through a plate may be than the plate is thick
        LookParams open = plan.look;
        open.transfer.kinds = kinds;
        Look look = chooseLook(open, samples, std::min(std::cbrt(voxels), kOblique * narrowest));
        look.background = plan.background;
        return look;
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", first.string(), error.what()));
    }
}

namespace {

/// Points around the solids of the frames.
std::vector<glm::dvec3> solidPoints(const PicturePlan& plan,
                                    std::span<const std::shared_ptr<const LoadedTexture>> frames)
{
    std::vector<glm::dvec3> points;
    for (const auto& frame :
         frames.first(plan.solid.changes() ? frames.size() : std::min<std::size_t>(1, frames.size()))) {
        try {
            const auto more = solidExtent(makeSolid(plan.solid, *frame->domain(), plan.stretch, frame->file.frame));
            points.insert(points.end(), more.begin(), more.end());
        } catch (const InputError&) { // is reported at the frame's turn
        }
    }
    return points;
}

/// Add the points of the ground that lie below the points of a subject, where most of its shadow falls.
void addOnGround(const PicturePlan& plan, const Corners& box, std::vector<glm::dvec3>& subject)
{
    const glm::dvec3 up = plan.camera.up.value_or(glm::dvec3(0, 0, 1));
    const GroundPlane plane = groundPlane(plan.ground.side, up, box, nullptr);
    for (std::size_t i = 0, count = subject.size(); i < count; ++i)
        subject.push_back(subject[i] + plane.normal * (plane.height - glm::dot(subject[i], plane.normal)));
}

} // namespace

std::vector<glm::dvec3> sceneSubject(const PicturePlan& plan, const Look& look,
                                     std::span<const std::shared_ptr<const LoadedTexture>> frames, const Corners& box,
                                     Exchange& exchange)
{
    std::vector<glm::dvec3> subject;
    if (plan.camera.eye && plan.camera.projection == Projection::kPerspective) return subject;
    const AnnotationParams& annotations = plan.annotations;
    if (annotations.box || annotations.axes) {
        subject.assign(box.begin(), box.end());
    } else {
        if (!plan.solid.source.empty()) subject = solidPoints(plan, frames);
        for (const auto& frame : frames) {
            const auto more = visibleExtent(frame->volume, look, plan.rays.clip.stretched(plan.stretch), exchange);
            subject.insert(subject.end(), more.begin(), more.end());
        }
        if (plan.ground.side != GroundSide::kNone) addOnGround(plan, box, subject);
    }
    if (!annotations.axes && !annotations.colorBar) return subject;
    const Camera view(plan.camera, box, plan.scaledSize(), subject);
    return withRoom(std::move(subject), annotations, view);
}

Scene chooseScene(const PicturePlan& plan, std::span<const std::shared_ptr<const LoadedTexture>> frames,
                  const Corners& box, const FrameSpan& span, Exchange& exchange)
{
    LookBasis basis;
    for (const auto& frame : frames)
        basis.add(*frame, exchange);
    Look look = basis.choose(plan);
    std::vector<glm::dvec3> subject = sceneSubject(plan, look, frames, box, exchange);
    const CameraPath cameras(plan.camera, plan.motion, box, plan.scaledSize(), span, std::move(subject));
    return {std::move(look), basis.opacityBy, cameras, box, basis.volumeBytes + plan.imageBytes(),
            basis.lastFrame, basis.longest};
}

namespace {

/// A rank's part of a frame; nothing for a process alone.
std::optional<BoxShare> boxOf(const FrameFile& file, const std::string& grid, const Exchange& exchange)
{
    if (exchange.isAlone()) return std::nullopt;
    const std::optional<GridHeader> header = textureHeader(file, grid);
    return BoxShare(header ? header->box : openvdb::CoordBBox(), exchange.rank(), exchange.size());
}

} // namespace

std::optional<SceneSource> sceneSource(const SequenceParams& input, const PicturePlan& plan)
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
    std::vector<FrameFile> lookFrames{bounds->firstFilled};
    for (std::size_t i = 1; i < std::min(kLookFrames, files.size()); ++i) {
        const FrameFile& file = files[i * (files.size() - 1) / (std::min(kLookFrames, files.size()) - 1)];
        if (file.frame != bounds->firstFilled.frame) lookFrames.push_back(file);
    }
    return SceneSource{files.size(), span, bounds->box, std::move(lookFrames)};
}

std::optional<SequenceScene> sceneOfSequence(const RenderPlan& plan, Exchange& exchange)
{
    const std::optional<SceneSource> source = sceneSource(plan.input, plan.picture);
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
    std::erase_if(frames, [](const auto& frame) { return frame->volume.empty(); });
    if (frames.empty()) return std::nullopt;
    SequenceScene result{chooseScene(plan.picture, frames, source->box, source->span, exchange), nullptr};
    if (source->frameCount == 1 && exchange.isAlone()) result.onlyFrame = frames.front();
    return result;
}

} // namespace vdblic
