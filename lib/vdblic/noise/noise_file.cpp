#include "vdblic/noise/noise_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/whole_vdb.h"
#include "vdblic/noise/noise.h"

#include <fmt/format.h>

#include <cstdint>
#include <memory>

namespace vdblic {
namespace {

constexpr double kBytes = 9; // per voxel: its value in memory and in the file

openvdb::GridBase::Ptr findGrid(const GridReference& reference)
{
    const VdbFile file = readVdb(reference.path);
    if (!reference.grid.empty()) return file.get<openvdb::GridBase>(reference.grid);
    for (const openvdb::GridBase::Ptr& grid : file.grids) {
        if (grid->activeVoxelCount() > 0) return grid;
    }
    throw file.missing("grid with active voxels");
}

openvdb::MaskTree::Ptr topologyOf(const openvdb::GridBase& grid, const std::string& name)
{
    openvdb::MaskTree::Ptr topology;
    const bool known = grid.apply<openvdb::GridTypes>([&](const auto& typed) {
        topology = std::make_shared<openvdb::MaskTree>(typed.tree(), false, openvdb::TopologyCopy());
    });
    if (!known) throw InputError(fmt::format("{}: grids of type {} are not supported", name, grid.type()));
    return topology;
}

} // namespace

Parameters parametersOf(NoiseParams& params)
{
    return {
        parameter("output", "The .vdb file to write.", params.output, {.option = "-o,--output", .isRequired = true}),
        parameter("like",
                  "Grid whose active voxels and transform the noise has; by default the first in the file that has "
                  "active voxels.",
                  params.like, {.words = "FILE[:GRID]", .excludes = "size"}),
        parameter("size", "Voxels along x, y and z of a box.", params.size, {.words = "X Y Z"}),
        refineParameter("Voxels of the noise along each axis in a voxel of the grid that it is like.",
                        params.refinement),
        parameter("seed", "Another seed gives other noise.", params.seed),
        skipExistingParameter(params.skipExisting),
    };
}

void NoiseParams::validate() const
{
    if (like.empty() == !size.has_value()) throw ParameterError("give one of `like` FILE and `size` X Y Z");
    if (size) checkBoxSize(*size);
    if (size && !refinement.isNone())
        throw ParameterError("`refine` refines the voxels of `like`; give a larger `size`");
    refinement.validate();
    checkExtension(output, {".vdb"});
}

void makeNoiseFile(const NoiseParams& params, Reporter& reporter)
{
    params.validate();
    if (params.skipExisting && isWholeVdb(params.output, reporter)) {
        reporter.finished(params.output);
        reporter.say(fmt::format("{}: was there already", params.output));
        return;
    }
    checkOutput(params.output);
    openvdb::FloatGrid::Ptr noise;
    if (params.size) {
        paging::makeRoom(kBytes * (*params.size)[0] * (*params.size)[1] * (*params.size)[2]);
        const auto transform = openvdb::math::Transform::createLinearTransform(kDefaultVoxelSize);
        noise = makeNoise(*boxDomain(*params.size), *transform, params.seed);
    } else {
        const GridReference reference = parseGridReference(params.like);
        checkNotInput(params.output, reference.path);
        const openvdb::GridBase::Ptr grid = findGrid(reference);
        const std::string name = fmt::format("{}: grid '{}'", reference.path.string(), grid->getName());
        const Refinement& refinement = params.refinement;
        const std::uint64_t voxels = grid->activeVoxelCount();
        if (voxels == 0) throw InputError(fmt::format("{} has no active voxels", name));
        if (voxels > std::uint64_t(kMaxBoxVoxels / refinement.voxels())) {
            throw InputError(fmt::format("{} has {} active voxels; at most {} are supported", name, voxels,
                                         kMaxBoxVoxels / refinement.voxels()));
        }
        reporter.say(fmt::format("like {} ({}), {} active voxels", name, grid->valueType(), voxels));
        const auto stored = double(grid->baseTree().leafCount()) * Domain::kLeafVoxels;
        paging::makeRoom(double(grid->memUsage()) + kBytes * stored * refinement.voxels());
        try {
            openvdb::MaskTree::Ptr topology = topologyOf(*grid, name);
            if (!refinement.isNone()) topology = refinement.refined(*topology);
            noise = makeNoise(Domain(topology), *refinement.refined(grid->transform()), params.seed);
        } catch (const InputError& error) {
            throw InputError(fmt::format("{}: {}", name, error.what()));
        }
    }
    writeVdb(params.output, {noise}, {});
    reporter.finished(params.output);
}

openvdb::FloatGrid::ConstPtr readNoise(const std::string& argument)
{
    const auto [path, named] = parseGridReference(argument);
    const std::string name = named.empty() ? "noise" : named;
    const VdbFile file = readVdb(path);
    const auto grid = file.get<openvdb::FloatGrid>(name, "FILE:GRID");
    for (auto value = grid->cbeginValueOn(); value; ++value) {
        if (!(*value >= 0 && *value <= 1)) {
            const openvdb::Coord at = value.getCoord();
            throw InputError(fmt::format("{}: grid {}: value {} at [{}, {}, {}] is outside 0 to 1", path.string(), name,
                                         *value, at[0], at[1], at[2]));
        }
    }
    return grid;
}

} // namespace vdblic
