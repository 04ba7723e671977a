#include "vdblic/field/synth.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/globe.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

double timeOf(std::int64_t frame, double dt)
{
    return double(frame - 1) * dt;
}

void checkPlace(const AnalyticFlow& flow, const std::optional<BoxSize>& size, double voxelSize)
{
    if (flow.isOnGlobe) {
        if (size)
            throw ParameterError(fmt::format("`size` is not for {}, whose Earth has a size; leave it out", flow.name));
        checkGlobe(voxelSize);
        return;
    }
    if (!size) throw ParameterError(fmt::format("`size` is missing: the voxels of {} along x, y and z", flow.name));
    checkBoxSize(*size);
    checkVoxelSize(voxelSize);
}

/// Bytes of all grids, in memory and in the file.
double bytesOf(const AnalyticFlow& flow, const std::optional<BoxSize>& size, double voxelSize)
{
    constexpr double kInBox = 26, kOnGlobe = 64; // a voxel
    if (flow.isOnGlobe) return kOnGlobe * voxelsOfGlobe(voxelSize);
    return kInBox * (*size)[0] * (*size)[1] * (*size)[2];
}

} // namespace

Parameters parametersOf(SynthParams& params)
{
    return {
        parameter("flow", "Name of the flow; --list shows them.", params.flow, {.option = "FLOW", .isRequired = true}),
        parameter("output", "The files to write, as a pattern such as velocity.%04d.vdb.", params.output,
                  {.option = "-o,--output", .isRequired = true}),
        parameter("size", "Voxels along x, y and z of the box; a globe has none.", params.size, {.words = "X Y Z"}),
        parameter("frames", "Frames to make: 1-100, 1-100x2 or 1,5,9-20; frame 1 is at time 0.", params.frames,
                  {.isRequired = true}),
        parameter("dt",
                  "Seconds from one frame number to the next. With the default a flow moves by about 3 voxels a frame.",
                  params.dt, {.unit = "s"}),
        parameter("voxel_size",
                  "Voxel size in world units, those of a globe 1000 km; velocities are in these per second.",
                  params.voxelSize),
    };
}

void SynthParams::validate() const
{
    const AnalyticFlow& known = findAnalyticFlow(flow);
    checkPlace(known, size, voxelSize);
    const double longest = known.isOnGlobe ? 1e9 : 1e6; // seconds; the flows' sines lose precision beyond
    const double seconds = dt.value_or(SynthFlow::dt(known, voxelSize));
    if (!(seconds > 0 && seconds <= longest)) {
        throw ParameterError(fmt::format("dt {}: must be a positive number of seconds, at most {}", seconds, longest));
    }
    const std::vector<std::int64_t> selected = parseFrameList(frames);
    for (const std::int64_t frame : {selected.front(), selected.back()}) {
        if (std::abs(timeOf(frame, seconds)) > longest) {
            throw ParameterError(fmt::format("frame {} is at {} seconds; at most {} are supported, choose a smaller dt",
                                             frame, timeOf(frame, seconds), longest));
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

SynthFlow::SynthFlow(std::string_view name, const std::optional<BoxSize>& size, double voxelSize)
{
    const AnalyticFlow& flow = findAnalyticFlow(name);
    checkPlace(flow, size, voxelSize);
    mTransform = openvdb::math::Transform::createLinearTransform(voxelSize);
    if (flow.isOnGlobe) {
        Globe globe = makeGlobe(voxelSize);
        mFlow = flow.make({});
        mDomain = std::move(globe.domain);
        mFixed = {globe.rim, globe.solid};
    } else {
        mFlow = flowInBox(flow, *size, voxelSize);
        mDomain = boxDomain(*size);
    }
}

double SynthFlow::dt(const AnalyticFlow& flow, double voxelSize)
{
    return flow.isOnGlobe ? 72'000 * voxelSize : 1.0 / 24;
}

openvdb::GridPtrVec SynthFlow::at(double time) const
{
    openvdb::GridPtrVec grids{sampleFlow(mFlow, *mDomain, *mTransform, time)};
    if (!mFixed.empty()) {
        grids.push_back(speedOnEarth(*openvdb::gridPtrCast<openvdb::Vec3SGrid>(grids.front()), *mDomain));
        grids.front()->insertMeta("length_unit", openvdb::StringMetadata("Mm"));
    }
    grids.insert(grids.end(), mFixed.begin(), mFixed.end());
    return grids;
}

void synthSequence(const SynthParams& params, Reporter& reporter)
{
    params.validate();
    const AnalyticFlow& known = findAnalyticFlow(params.flow);
    paging::makeRoom(bytesOf(known, params.size, params.voxelSize));
    const SynthFlow flow(params.flow, params.size, params.voxelSize);
    const double dt = params.dt.value_or(SynthFlow::dt(known, params.voxelSize));
    const FramePattern pattern(params.output);
    const std::vector<std::int64_t> frames = parseFrameList(params.frames);
    checkOutputs(pattern, frames);
    std::size_t done = 0;
    for (const std::int64_t frame : frames) {
        reporter.checkStop();
        reporter.progress(done++, frames.size());
        const double time = timeOf(frame, dt);
        const openvdb::GridPtrVec grids = flow.at(time);
        grids.front()->insertMeta("frame", openvdb::Int64Metadata(frame));
        grids.front()->insertMeta("time", openvdb::DoubleMetadata(time));
        grids.front()->insertMeta("dt", openvdb::DoubleMetadata(dt));
        writeVdb(pattern.path(frame), {grids.begin(), grids.end()}, {});
        reporter.finished(pattern.path(frame));
    }
    reporter.progress(done, frames.size());
}

} // namespace vdblic
