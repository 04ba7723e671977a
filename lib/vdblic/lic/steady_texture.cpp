#include "vdblic/lic/steady_texture.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/path_reach.h"
#include "vdblic/lic/pathline.h"
#include "vdblic/noise/noise.h"

#include <tbb/enumerable_thread_specific.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace vdblic {
namespace {

/// Weighted noise along the streamlines of eight voxels at a time. One object serves one thread.
struct Convolution {
    const LeafValues<std::int32_t>& noise;
    const PathlineParams& pathline;
    PathBatch batch{};
    PathSamples samples{};
    std::vector<std::int32_t> values{}; // along one half of a streamline

    /// Add one half of the streamlines of voxels in a row, given by the bits of `lanes`.
    VDBLIC_INLINE void addHalf(const VelocityField& field, const Bricks::Window& fieldWindow, const LeafWindow& window,
                               const openvdb::Coord& row, unsigned lanes, Float8& sum, Float8& weight)
    {
        const Domain& domain = field.domain();
        batch.lanes = lanes;
        batch.position = rowCentres(row[0], row[1], row[2]);
        batch.slope = field.sample(fieldWindow, batch.position, Float8{}, Vector8{}, lanes);
        advancePaths(field, fieldWindow, pathline, batch);
        samplePaths(batch, domain, window, pathline.sampleSpacing, 0, samples);
        for (int lane = 0; lane < kLanes; ++lane) {
            if (!(lanes >> lane & 1)) continue;
            collect(domain, window, lane);
            for (std::size_t i = 0; i < values.size(); ++i) {
                const float s = (float(i) + 0.5f) / float(values.size());
                const float share = 0.5f + 0.5f * std::cos(std::numbers::pi_v<float> * s);
                sum[lane] += share * float(values[i]);
                weight[lane] += share;
            }
        }
    }

    /// The noise along one lane's path, up to where it leaves the domain.
    void collect(const Domain& domain, const LeafWindow& window, int lane)
    {
        values.clear();
        for (const PathSamples::Run& run : samples.runs) {
            for (int i = 0; run.lanes >> lane & 1 && i < run.count[lane]; ++i) {
                const WindowVoxel sample = samples.rows[run.firstRow + std::size_t(i)].voxel(lane);
                const PathSamples::Voxel voxel = samples.find(sample, window);
                if (voxel.leaf < 0 || !domain.isActive(voxel.leaf, voxel.offset)) return;
                values.push_back(noise[std::size_t(voxel.leaf)][voxel.offset]);
            }
        }
    }
};

VDBLIC_KERNEL void convolveLeaf(Convolution& convolution, const VelocityField& downstream,
                                const VelocityField& upstream, std::size_t leaf, float* texture)
{
    const Domain& domain = downstream.domain();
    const openvdb::Coord origin = domain.origin(leaf);
    const LeafWindow window(domain, origin);
    const Bricks::Window below = downstream.window(origin), above = upstream.window(origin);
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const unsigned lanes = domain.mask(leaf).getWord<std::uint8_t>(openvdb::Index(row));
        if (lanes == 0) continue;
        const openvdb::Coord first = origin + openvdb::Coord(LeafVoxel::ofRow(row).x, LeafVoxel::ofRow(row).y, 0);
        Float8 sum{}, weight{};
        convolution.addHalf(downstream, below, window, first, lanes, sum, weight);
        convolution.addHalf(upstream, above, window, first, lanes, sum, weight);
        const Float8 mean = sum / weight / float(kNoiseMax);
        for (int z = 0; z < LeafVoxel::kDim; ++z) {
            if (lanes >> z & 1) texture[LeafVoxel::kDim * row + z] = mean[z];
        }
    }
}

} // namespace

SteadyTexture::SteadyTexture(const TextureParams& params, NoiseField noise) : mParams(params), mNoise(std::move(noise))
{
}

FlowTextureStep SteadyTexture::advance(const FlowStep& step)
{
    StageClock clock;
    const FlowFrame& frame = step.start;
    const Domain& domain = *frame.domain;
    const double half = 0.5 * mParams.lifeSpan * mParams.substeps; // of the kernel [steps]
    VelocityField downstream, upstream;
    const auto prepare = [&](VelocityField& field, double length) {
        const VelocityLevel level{frame.velocities->tree(), step.startToStep * length};
        field.prepare(frame.fieldDomain(), level, level);
    };
    {
        const auto stage = clock.enter(&StageTimes::load);
        prepare(downstream, half);
        prepare(upstream, -half);
    }
    FlowTextureStep result;
    {
        const auto stage = clock.enter(&StageTimes::convolve);
        const LeafValues<std::int32_t> input = noiseInput(domain, mNoise, domain.local());
        result.texture = LeafValues<float>(domain, 0.0f);
        tbb::enumerable_thread_specific<Convolution> workers([&] { return Convolution{input, mParams.pathline}; });
        const Slabs slabs(domain, frame.refinement),
            velocitySlabs(slabs, *downstream.sampledDomain().velocity, downstream.sampledDomain().refinement);
        const auto finer = float(downstream.sampledDomain().refinement.factors[std::size_t(slabs.axis())] - 1);
        slabs.sweep(
            leavesReached(longestPath(downstream.largest()[slabs.axis()]) + finer),
            [&](std::size_t slab) {
                const auto inner = clock.enter(&StageTimes::load);
                downstream.fill(velocitySlabs[slab]);
                upstream.fill(velocitySlabs[slab]);
            },
            [&](std::size_t slab) {
                downstream.release(velocitySlabs[slab]);
                upstream.release(velocitySlabs[slab]);
            },
            [&](std::size_t slab) {
                forLeaves(slabs[slab], [&](std::size_t leaf) {
                    if (domain.isOwn(leaf))
                        convolveLeaf(workers.local(), downstream, upstream, leaf, result.texture[leaf]);
                });
            });
    }
    result.times = clock.times();
    result.domain = frame.domain;
    result.refinement = frame.refinement;
    ++mStep;
    return result;
}

std::array<float, 3> SteadyTexture::farthestPath(const std::array<float, 3>& displacement, double /*interval*/) const
{
    std::array<float, 3> farthest{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        farthest[axis] = longestPath(0.5f * float(mParams.lifeSpan) * displacement[axis]);
    return farthest;
}

} // namespace vdblic
