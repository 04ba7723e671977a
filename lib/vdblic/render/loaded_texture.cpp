#include "vdblic/render/loaded_texture.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/derived_grids.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/field/resample.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/velocity_grids.h"
#include "vdblic/render/frame_metadata.h"
#include "vdblic/render/loaded_lines.h"
#include "vdblic/render/moment.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/sequence_bounds.h"
#include "vdblic/render/view.h"
#include "vdblic/volume/coarse_scalar.h"
#include "vdblic/volume/leaf_share.h"
#include "vdblic/volume/visible_space.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace vdblic {
namespace {

/// The message for a scalar grid that a file lacks, with the command that makes it.
InputError missingScalar(const VdbFile& file, const std::vector<std::string>& names, std::string choice)
{
    const auto made =
        std::find_first_of(names.begin(), names.end(), std::begin(kDerivedNames), std::end(kDerivedNames));
    if (made != names.end()) choice += fmt::format(", or make it with vdblic_advect --with {}", *made);
    return file.missing(fmt::format("float grid '{}'", fmt::join(names, "' or '")), choice);
}

/// The texture's grid. @throws InputError
openvdb::FloatGrid::Ptr textureOf(const VdbFile& file, const std::string& name)
{
    const auto isVelocity = [](const openvdb::GridBase::Ptr& grid) { return isVector(*grid); };
    if (!file.find<openvdb::FloatGrid>(name) && std::ranges::any_of(file.grids, isVelocity)) {
        throw InputError(fmt::format("{}: holds a velocity and no texture '{}'; vdblic_film shows a velocity, and "
                                     "vdblic_advect makes its texture",
                                     file.path.string(), name));
    }
    return file.get<openvdb::FloatGrid>(name, "`texture`");
}

/// The first of a file's float grids with one of these names.
openvdb::FloatGrid::Ptr findScalar(const VdbFile& file, const std::vector<std::string>& names)
{
    for (const std::string& name : names) {
        if (auto grid = file.find<openvdb::FloatGrid>(name)) return grid;
    }
    return nullptr;
}

/// Of a sparse texture's file, a grid whose active voxels are the flow's. Sources have the streaks' voxels.
/// @param color grid that colour follows; or null
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

/// Voxels around visible leaves whose records are read: lines read the next leaf too.
int rimOf(const PicturePlan& plan)
{
    return plan.look.shading.model == ShadingModel::kLine ? LeafVoxel::kDim : 0;
}

/// The memory of a leaf of a frame's two grids, and of the tables of its picture.
constexpr double kLeafBytes =
    2 * (sizeof(openvdb::FloatTree::LeafNodeType::Buffer) + LeafVoxel::kCount * sizeof(float)) +
    double(VisibleSpace::kBytesPerLeaf);

} // namespace

openvdb::FloatGrid::ConstPtr LoadedTexture::domain() const
{
    if (!flowVoxels && tubes) {
        throw InputError(fmt::format("{}: `solid` domain needs the flow's voxels beside the lines; make them with "
                                     "vdblic_advect --with {}",
                                     file.path.string(), kSpeedGrid));
    }
    if (!flowVoxels) return texture;
    constexpr int kFine = 4; // voxels: a level set rounds its edges over about one
    Refinement refinement;
    if (tubes) refinement.factors.fill(kFine);
    const auto ofTexture = tubes ? std::nullopt : Refinement::between(flowVoxels->transform(), texture->transform());
    if (ofTexture) {
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

void LoadedTexture::addTo(TextureHistograms& histograms) const
{
    if (tubes) {
        const VolumeSamples samples = tubes->samples();
        histograms.add(samples);
        return;
    }
    try {
        const auto onTexture = resampledOn(color, *texture);
        histograms.add(*texture, *onTexture, opacity == color ? *onTexture : *resampledOn(opacity, *texture));
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", file.path.string(), error.what()));
    }
}

double LoadedTexture::bytes() const
{
    const double own = tubes ? tubes->bytes() : double(volume->leafCount()) * (kLeafBytes + volume->bytesPerLeaf());
    return own + (lines ? lines->bytes() : 0);
}

double bytesPerVoxel(const PicturePlan& plan)
{
    const bool hasLines = plan.look.shading.model == ShadingModel::kLine;
    const int scalars = plan.opacityBy.empty() ? 1 : 2;
    const double records = TextureVolume::bytesPerLeaf(hasLines, scalars * double(ScalarLeaf::kSize * sizeof(float)));
    return (kLeafBytes + records) / LeafVoxel::kCount;
}

LoadedTexture loadFrame(const PicturePlan& plan, const FrameFile& frame, const View* view, const LeafShare* share)
{
    // Lines need no voxel's value; each rank has all of them.
    const auto noValues = [](const openvdb::GridBase&, const openvdb::Coord&) { return false; };
    if (hasLines(frame.path, plan.texture)) return loadFrame(plan, readVdb(frame.path, noValues), frame, view);
    if (!share) return loadFrame(plan, readVdb(frame.path), frame, view);
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
    return loadFrame(plan, file, frame, view, share);
}

LoadedTexture loadFrame(const PicturePlan& plan, const Moment& moment, const View* view, const LeafShare* share)
{
    LoadedTexture loaded = moment.next ? linesAt(plan, moment, view) : loadFrame(plan, moment.file, view, share);
    if (loaded.clock.dt) *loaded.clock.dt /= moment.substeps;
    return loaded;
}

LoadedTexture loadFrame(const PicturePlan& plan, const VdbFile& file, const FrameFile& frame, const View* view,
                        const LeafShare* share)
{
    const std::string name = textureName(file.metadata, plan.texture);
    if (auto lines = linesIn(plan, file, frame, view ? view->opacityBy : "")) return std::move(*lines);
    const auto texture = textureOf(file, name);
    std::vector<std::string> opacityBy = plan.opacityBy;
    if (view && !opacityBy.empty()) opacityBy = {view->opacityBy};
    const auto storedColor = findScalar(file, {plan.colorBy});
    if (!storedColor && plan.colorBy != kSpeedGrid)
        throw missingScalar(file, {plan.colorBy}, opacityBy.empty() ? "`by`" : "`color_by`");
    const auto storedOpacity = opacityBy.empty() ? storedColor : findScalar(file, opacityBy);
    if (!storedOpacity && !opacityBy.empty()) throw missingScalar(file, opacityBy, "`opacity_by`");
    const auto lines = plan.lines.empty() ? nullptr : linesBeside(plan, frame, view);
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
        // The lines at a leaf's rim come from its neighbours.
        const RecordUse use{.look = hasLines || !view ? nullptr : &view->look,
                            .share = share,
                            .rim = rimOf(plan),
                            .isSparse = isSparse};
        LoadedTexture loaded{.file = frame,
                             .name = name,
                             .texture = texture,
                             .color = color,
                             .opacity = opacity,
                             .hasColor = bool(storedColor),
                             .opacityBy = storedOpacity ? storedOpacity->getName() : plan.colorBy,
                             .volume = TextureVolume(*texture, *opacity, plan.stretch, use),
                             .clock = clockOf(file.metadata),
                             .colorUnit = unitOf(*color, lengthUnit),
                             .opacityUnit = unitOf(*opacity, lengthUnit),
                             .lengthUnit = lengthUnit,
                             .isSparse = isSparse,
                             .lines = lines,
                             .flowVoxels = isSparse ? flowVoxelsOf(file, storedColor) : nullptr};
        if (color->getName() == kSourceGrid) loaded.kinds = kindsOf(file.metadata);
        if (opacity != color || !plan.look.transfer.sharesRange()) loaded.volume->addColors(*texture, *color);
        if (!plan.region.empty() || plan.regionBox) {
            const auto topology = std::make_shared<openvdb::MaskTree>(loaded.volume->domain().topology());
            const DomainParams region{.mask = plan.region, .worldBox = plan.regionBox};
            loaded.volume->cut(*makeDomain(topology, texture->transform(), region, frame.frame).texture);
        }
        if (hasLines) loaded.volume->addLines();
        return loaded;
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", frame.path.string(), error.what()));
    }
}

} // namespace vdblic
