#include "vdblic/run/texture_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/derived_grids.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/resample.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocity_leaf.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/vdb_header.h"
#include "vdblic/lic/finish.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lines/line_grid.h"
#include "vdblic/run/advect_plan.h"
#include "vdblic/run/line_output.h"
#include "vdblic/run/texture_run.h"
#include "vdblic/run/velocity_output.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

VDBLIC_KERNEL void fillMagnitudes(const Domain::Mask& mask, const VelocityLeaf& velocities, float* magnitudes)
{
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const Float8 magnitude = squareRoots(squaredLength(velocities.row(row).velocities));
        storeRow(activeRow(mask, row) ? magnitude : Float8{}, magnitudes, row);
    }
}

openvdb::FloatTree::Ptr magnitudeOf(const Domain& domain, const Velocities<Space::kWorld, Per::kSecond>& velocities)
{
    LeafValues<float> magnitude(domain, 0.0f);
    forLeaves(domain.local(), [&](std::size_t leaf) {
        fillMagnitudes(domain.mask(leaf), VelocityLeaf(velocities, domain.origin(leaf)), magnitude[leaf]);
    });
    return magnitude.tree();
}

openvdb::FloatGrid::Ptr fogVolume(const openvdb::FloatTree::Ptr& tree, const std::string& name,
                                  const openvdb::math::Transform& transform)
{
    auto grid = openvdb::FloatGrid::create(tree);
    grid->setName(name);
    grid->setTransform(transform.copy());
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

openvdb::Int32Grid::Ptr hitsGrid(const openvdb::Int32Tree::Ptr& tree, const openvdb::math::Transform& transform)
{
    auto grid = openvdb::Int32Grid::create(tree);
    grid->setName(kHitsGrid);
    grid->setTransform(transform.copy());
    return grid;
}

/// Bring a step's grids from the observer's space back to their places in the world. Carried grids and the scalars
/// beside lines, which stay until the next frame on disk, have that frame's place.
/// @param substeps in the interval  @param scalars number of grids, the first ones, that stay
void bringBack(const TextureFrame& made, int substeps, std::size_t scalars, openvdb::GridCPtrVec& grids)
{
    const VelocityFrame& frame = made.frame;
    const double ofStep = frame.observedSeconds, ofFrame = ofStep - made.interval * made.substep / substeps;
    for (std::size_t i = 0; i < grids.size(); ++i) {
        const bool stays = i < scalars || std::ranges::count(frame.carried, grids[i]) > 0;
        grids[i] = grids[i]->copyGridReplacingTransform(
            frame.observer->toWorld(grids[i]->transform(), stays ? ofFrame : ofStep));
    }
}

/// A tree with all of a domain's voxels: the texture's, unless other ranks hold parts.
openvdb::FloatTree::Ptr wholeTree(const Domain& domain, const openvdb::FloatTree::Ptr& texture)
{
    if (domain.isWhole()) return texture;
    return std::make_shared<openvdb::FloatTree>(domain.topology(), 0.0f, openvdb::TopologyCopy());
}

/// @param refinement of the computed texture
openvdb::MetaMap parameterMetadata(const AdvectPlan& plan, const Refinement& refinement)
{
    const AdvectParams& params = plan.params;
    openvdb::MetaMap metadata;
    metadata.insertMeta(kTextureKey, openvdb::StringMetadata(params.writesLines() ? kLineGrid : params.textureName));
    const TextureParams& texture = params.texture;
    metadata.insertMeta("method", openvdb::StringMetadata(std::string(texture.method->name)));
    texture.method->describe(params, metadata);
    metadata.insertMeta("substeps", openvdb::Int32Metadata(texture.substeps));
    const std::array<int, 3>& factors = refinement.factors;
    metadata.insertMeta("refine", openvdb::Vec3IMetadata(openvdb::Vec3i(factors[0], factors[1], factors[2])));
    metadata.insertMeta("interpolation", openvdb::StringMetadata(std::string(nameOf(refinement.interpolation))));
    if (const std::vector<std::string>& axes = params.flow.domain.periodic; !axes.empty())
        metadata.insertMeta("periodic", openvdb::StringMetadata(fmt::format("{}", fmt::join(axes, ","))));
    metadata.insertMeta("sample_spacing", openvdb::FloatMetadata(texture.pathline.sampleSpacing));
    metadata.insertMeta("tolerance", openvdb::FloatMetadata(texture.pathline.tolerance));
    metadata.insertMeta("finish", openvdb::Int32Metadata(plan.finish));
    if (!texture.method->isSteady) {
        metadata.insertMeta("preroll", openvdb::Int32Metadata(plan.preroll));
        if (plan.framesBefore > 0) metadata.insertMeta("lead_in", openvdb::Int32Metadata(plan.leadIn));
    }
    if (params.noise.empty()) {
        metadata.insertMeta("seed", openvdb::Int64Metadata(params.seed));
    } else {
        metadata.insertMeta("noise", openvdb::StringMetadata(params.noise));
    }
    return metadata;
}

} // namespace

TextureFile makeTextureFile(const AdvectPlan& plan, TextureFrame& made, std::int64_t number, Exchange& exchange,
                            int writer)
{
    const AdvectParams& params = plan.params;
    const VelocityFrame& frame = made.frame;
    const FromStored<Space::kWorld, Per::kSecond> toWorldPerSecond = frame.toWorldPerSecond(made.interval);
    const openvdb::math::Transform::Ptr ofTexture = made.transform();
    const openvdb::math::Transform& transform = *ofTexture;
    const bool returns = frame.observer && !params.flow.observer.stay;
    openvdb::FloatTree::Ptr texture;
    openvdb::FloatGrid::Ptr textureGrid;
    if (!params.writesLines()) {
        texture = finish(frame, made.interval, std::move(made.texture), {plan.finish}).tree();
        textureGrid = fogVolume(texture, params.textureName, transform);
    }
    std::vector<openvdb::FloatGrid::Ptr> scalars =
        derivedGrids(params.derivedScalars(), *frame.domain.velocity, *frame.values, toWorldPerSecond);
    scalars.insert(scalars.begin(),
                   fogVolume(magnitudeOf(*frame.domain.velocity, {frame.values->tree(), toWorldPerSecond}), "magnitude",
                             frame.values->transform()));
    openvdb::GridPtrVec carried = frame.carried;
    const openvdb::GridBase::Ptr lines = params.writesLines() ? lineOutput(exchange, writer, scalars, made) : nullptr;
    if (params.format.scalars == ScalarVoxels::kTexture && !made.refinement.isNone()) {
        for (openvdb::FloatGrid::Ptr& scalar : scalars)
            scalar = resampled(*scalar, *textureGrid);
        const openvdb::FloatGrid::Ptr like = fogVolume(wholeTree(*made.domain, texture), "", transform);
        for (openvdb::GridBase::Ptr& grid : carried) {
            if (const auto scalar = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) grid = resampled(*scalar, *like);
        }
    }
    if (params.writesVelocity()) {
        if (!frame.domain.velocity->isWhole())
            throw ParameterError("`derived` velocity: only a run by one process writes it; use vdblic_advect");
        const bool onTexture = params.format.scalars == ScalarVoxels::kTexture && !made.refinement.isNone();
        carried.insert(carried.begin(),
                       velocityGrid(*frame.domain.velocity, *frame.values, toWorldPerSecond * frame.motion,
                                    returns ? frame.observer->unseen(frame.observedSeconds) : VelocityMap{},
                                    onTexture ? textureGrid.get() : nullptr, params.format.precision));
    }
    if (lines) carried.insert(carried.begin(), lines);
    if (made.source.tree()) scalars.insert(scalars.begin(), fogVolume(made.source.tree(), kSourceGrid, transform));
    if (params.format.precision == GridPrecision::kHalf) {
        if (textureGrid) textureGrid->setSaveFloatAsHalf(true);
        for (const openvdb::FloatGrid::Ptr& scalar : scalars)
            saveAsHalf(*scalar);
    }

    TextureFile file;
    if (textureGrid) file.grids = {textureGrid};
    if (made.hits.tree()) file.grids.push_back(hitsGrid(made.hits.tree(), transform));
    file.grids.insert(file.grids.end(), scalars.begin(), scalars.end());
    file.computed = file.grids.size();
    const bool hasSecond = made.source.tree() || made.hits.tree();
    file.onTexture = params.format.scalars == ScalarVoxels::kTexture ? file.computed : hasSecond ? 2 : 1;
    file.domain = made.domain;
    file.grids.insert(file.grids.end(), carried.begin(), carried.end());
    if (returns) bringBack(made, params.texture.substeps, params.writesLines() ? file.computed : 0, file.grids);
    file.metadata = parameterMetadata(plan, made.refinement);
    for (auto chosen = made.metadata.beginMeta(); chosen != made.metadata.endMeta(); ++chosen)
        file.metadata.insertMeta(chosen->first, *chosen->second);
    if (!frame.sourceCreator.empty())
        file.metadata.insertMeta("source_creator", openvdb::StringMetadata(frame.sourceCreator));
    if (frame.observer) frame.observer->describe(file.metadata);
    if (frame.motion != 1) file.metadata.insertMeta("motion", openvdb::DoubleMetadata(frame.motion));
    // With a frame spacing of its own a run no longer follows the files' calendar.
    if (!frame.start.empty() && !params.flow.frameSpacing)
        file.metadata.insertMeta("start", openvdb::StringMetadata(frame.start));
    if (!frame.lengthUnit.empty()) file.metadata.insertMeta("length_unit", openvdb::StringMetadata(frame.lengthUnit));
    file.metadata.insertMeta("frame", openvdb::Int64Metadata(number));
    file.metadata.insertMeta("source_frame", openvdb::DoubleMetadata(frame.sourceFrame));
    file.metadata.insertMeta("time", openvdb::DoubleMetadata(made.time));
    file.metadata.insertMeta("dt", openvdb::DoubleMetadata(made.interval / params.texture.substeps));
    return file;
}

std::string faultOf(const std::filesystem::path& output, std::int64_t number, const AdvectPlan& plan)
{
    if (!isFinished(output)) return "it is not there";
    try {
        if (!verifyVdb(output)) return "it has no checksums, as this run's outputs have";
        const openvdb::MetaMap found = readVdbHeader(output).metadata;
        const auto frame = found.getMetadata<openvdb::Int64Metadata>("frame");
        if (!frame || frame->value() != number)
            return frame ? fmt::format("it is frame {}", frame->value()) : "it is no texture";
        const Refinement& refinement = plan.params.flow.domain.refinement;
        const openvdb::MetaMap wanted = parameterMetadata(plan, refinement);
        for (auto entry = wanted.beginMeta(); entry != wanted.endMeta(); ++entry) {
            if (entry->first == "refine" && !refinement.isGiven) continue; // possibly chosen by the first frame
            const openvdb::Metadata::ConstPtr value = found[entry->first];
            if (!value || *value != *entry->second)
                return fmt::format("it is of another run, by its metadata '{}'", entry->first);
        }
    } catch (const InputError& error) {
        return fmt::format("it is damaged ({})", error.what());
    }
    return {};
}

} // namespace vdblic
