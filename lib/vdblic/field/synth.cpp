#include "vdblic/field/synth.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdblic {
namespace {

double timeOf(std::int64_t frame, double dt)
{
    return double(frame - 1) * dt;
}

} // namespace

Parameters parametersOf(SynthParams& params)
{
    return {
        parameter("flow", "Name of the flow; --list shows them.", params.flow, {.option = "FLOW", .isRequired = true}),
        parameter("output", "The files to write, as a pattern such as velocity.%04d.vdb.", params.output,
                  {.option = "-o,--output", .isRequired = true}),
        parameter("size", "Voxels along x, y and z.", params.size, {.words = "X Y Z", .isRequired = true}),
        parameter("frames", "Frames to make: 1-100, 1-100x2 or 1,5,9-20; frame 1 is at time 0.", params.frames,
                  {.isRequired = true}),
        parameter("dt",
                  "Seconds from one frame number to the next. With the default a flow moves by about 3 voxels a frame.",
                  params.dt, {.unit = "s"}),
        parameter("voxel_size", "Voxel size in world units; velocities are in these per second.", params.voxelSize),
    };
}

void SynthParams::validate() const
{
    (void)findAnalyticFlow(flow);
    checkBoxSize(size);
    checkVoxelSize(voxelSize);
    constexpr double kLongest = 1e6; // seconds; the flows' sines lose precision beyond
    if (!(dt > 0 && dt <= kLongest)) {
        throw ParameterError(fmt::format("dt {}: must be a positive number of seconds, at most {}", dt, kLongest));
    }
    const std::vector<std::int64_t> selected = parseFrameList(frames);
    for (const std::int64_t frame : {selected.front(), selected.back()}) {
        if (std::abs(timeOf(frame, dt)) > kLongest) {
            throw ParameterError(fmt::format("frame {} is at {} seconds; at most {} are supported, choose a smaller dt",
                                             frame, timeOf(frame, dt), kLongest));
        }
    }
    checkOutputPattern(FramePattern(output), selected.size());
    checkExtension(output, {".vdb"});
}

openvdb::Vec3SGrid::Ptr sampleFlow(const FlowFunction& flow, const Domain& domain,
                                   const openvdb::math::Transform& transform, double time)
{
    LeafValues<openvdb::Vec3f> values(domain, openvdb::Vec3f(0));
    forLeaves(domain.own(), [&](std::size_t leaf) {
        openvdb::Vec3f* velocities = values[leaf];
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const openvdb::Coord index = domain.origin(leaf) + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            velocities[voxel.pos()] = openvdb::Vec3f(flow(transform.indexToWorld(index), time));
        }
    });
    auto grid = openvdb::Vec3SGrid::create(values.tree());
    grid->setName("velocity");
    grid->setTransform(transform.copy());
    grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
    return grid;
}

void synthSequence(const SynthParams& params, Reporter& reporter)
{
    params.validate();
    const FlowFunction flow = flowInBox(findAnalyticFlow(params.flow), params.size, params.voxelSize);
    constexpr double kBytes = 26; // per voxel: its values in memory and in the file
    paging::makeRoom(kBytes * params.size[0] * params.size[1] * params.size[2]);
    const std::shared_ptr<const Domain> domain = boxDomain(params.size);
    const auto transform = openvdb::math::Transform::createLinearTransform(params.voxelSize);
    const FramePattern pattern(params.output);
    const std::vector<std::int64_t> frames = parseFrameList(params.frames);
    checkOutputs(pattern, frames);
    std::size_t done = 0;
    for (const std::int64_t frame : frames) {
        reporter.checkStop();
        reporter.progress(done++, frames.size());
        const double time = timeOf(frame, params.dt);
        const openvdb::Vec3SGrid::Ptr grid = sampleFlow(flow, *domain, *transform, time);
        grid->insertMeta("frame", openvdb::Int64Metadata(frame));
        grid->insertMeta("time", openvdb::DoubleMetadata(time));
        grid->insertMeta("dt", openvdb::DoubleMetadata(params.dt));
        writeVdb(pattern.path(frame), {grid}, {});
        reporter.finished(pattern.path(frame));
    }
    reporter.progress(done, frames.size());
}

} // namespace vdblic
