#include "vdblic/lic/streamline_convolution.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/slabs.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/path_reach.h"
#include "vdblic/lic/pathline.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace vdblic {
namespace {

/// Weights of samples at the middles of equal parts of half the kernel, by their number. One object serves one thread.
class HannWeights {
  public:
    /// The weights of a number of samples, from the kernel's middle on.
    const std::vector<float>& of(std::size_t samples)
    {
        if (mKnown.size() <= samples) mKnown.resize(samples + 1);
        std::vector<float>& weights = mKnown[samples];
        for (std::size_t i = weights.size(); i < samples; ++i) {
            const float s = (float(i) + 0.5f) / float(samples);
            weights.push_back(0.5f + 0.5f * std::cos(std::numbers::pi_v<float> * s));
        }
        return weights;
    }

  private:
    std::vector<std::vector<float>> mKnown;
};

/// Sums of weighted input along the streamlines of eight voxels at a time. One object serves one thread.
struct StreamlineSums {
    const LeafValues<float>& input;
    const PathlineParams& pathline;
    PathBatch batch{};
    PathSamples samples{};
    std::array<float, LeafVoxel::kCount> parts{}; // of the kernel, at the leaf's voxels
    std::vector<float> values{};                  // input along one half of a streamline
    HannWeights hann{};

    /// Add one half of the streamlines of a row's voxels. @param lanes bits of the voxels
    VDBLIC_INLINE void addHalf(const VelocityField& field, const Bricks::Window& fieldWindow, const LeafWindow& window,
                               const openvdb::Coord& row, unsigned lanes, Float8& sum, Float8& weight)
    {
        const Domain& domain = field.domain();
        batch.lanes = lanes;
        batch.position = rowCentres(row[0], row[1], row[2]);
        batch.slope = field.sample(fieldWindow, batch.position, Float8{}, Vector8{}, lanes);
        advancePaths(field, fieldWindow, pathline, batch);
        samplePaths(batch, domain, window, pathline.sampleSpacing, 0, samples);
        const int first = LeafVoxel::offset(row[0], row[1], row[2]);
        for (int lane = 0; lane < kLanes; ++lane) {
            if (!(lanes >> lane & 1)) continue;
            collect(domain, window, lane, parts[std::size_t(first + lane)]);
            const std::vector<float>& weights = hann.of(values.size());
            float sumHere = sum[lane], weightHere = weight[lane];
            for (std::size_t i = 0; i < values.size(); ++i) {
                sumHere += weights[i] * values[i];
                weightHere += weights[i];
            }
            sum[lane] = sumHere;
            weight[lane] = weightHere;
        }
    }

    /// The input along the first part of a lane's path, up to where it leaves the domain.
    void collect(const Domain& domain, const LeafWindow& window, int lane, float part)
    {
        int most = 0;
        for (const PathSamples::Run& run : samples.runs)
            most += run.lanes >> lane & 1 ? run.count[lane] : 0;
        if (part < 1) most = std::max(int(std::lround(float(most) * part)), 1);
        values.clear();
        for (const PathSamples::Run& run : samples.runs) {
            for (int i = 0; run.lanes >> lane & 1 && i < run.count[lane]; ++i) {
                const WindowVoxel sample = samples.rows[run.firstRow + std::size_t(i)].voxel(lane);
                const PathSamples::Voxel voxel = samples.find(sample, window);
                if (int(values.size()) == most || voxel.leaf < 0 || !domain.isActive(voxel.leaf, voxel.offset)) return;
                values.push_back(input[std::size_t(voxel.leaf)][voxel.offset]);
            }
        }
    }
};

VDBLIC_KERNEL void convolveLeaf(StreamlineSums& sums, const VelocityField& downstream, const VelocityField& upstream,
                                std::size_t leaf, float white, float* texture)
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
        sums.addHalf(downstream, below, window, first, lanes, sum, weight);
        sums.addHalf(upstream, above, window, first, lanes, sum, weight);
        const Float8 here = loadRow(sums.input[leaf], row); // where the flow is too fast to sample
        const Float8 mean = (weight > 0 ? sum / weight : here) / white;
        for (int z = 0; z < LeafVoxel::kDim; ++z) {
            if (lanes >> z & 1) texture[LeafVoxel::kDim * row + z] = mean[z];
        }
    }
}

} // namespace

LeafValues<float> StreamlineConvolution::operator()(const LeafValues<float>& input, float white,
                                                    StageClock& clock) const
{
    const FrameDomain& frame = step.start.domain;
    const Domain& domain = *frame.texture;
    VelocityField downstream, upstream;
    const auto prepare = [&](VelocityField& field, double length) {
        const FlowStep::Velocity velocities = step.startVelocities() * length;
        field.prepare(frame, velocities, velocities);
    };
    {
        const auto stage = clock.enter(&StageTimes::load);
        prepare(downstream, half);
        prepare(upstream, -half);
    }
    LeafValues<float> texture(domain, 0.0f);
    tbb::enumerable_thread_specific<StreamlineSums> workers([&] {
        StreamlineSums sums{input, pathline};
        sums.parts.fill(1);
        return sums;
    });
    const Slabs slabs(domain, frame.refinement),
        velocitySlabs(slabs, *downstream.sampledDomain().velocity, downstream.sampledDomain().refinement);
    const auto finer = float(downstream.sampledDomain().refinement.factors[std::size_t(slabs.axis())] - 1);
    slabs.sweep(
        leavesReached(longestPath(downstream.largest()[std::size_t(slabs.axis())]) + finer),
        [&](std::size_t slab) {
            const auto stage = clock.enter(&StageTimes::load);
            downstream.fill(velocitySlabs[slab]);
            upstream.fill(velocitySlabs[slab]);
        },
        [&](std::size_t slab) {
            downstream.release(velocitySlabs[slab]);
            upstream.release(velocitySlabs[slab]);
        },
        [&](std::size_t slab) {
            forLeaves(slabs[slab], [&](std::size_t leaf) {
                if (!domain.isOwn(leaf)) return;
                StreamlineSums& sums = workers.local();
                if (partsOf) partsOf(leaf, sums.parts.data());
                convolveLeaf(sums, downstream, upstream, leaf, white, texture[leaf]);
            });
        });
    return texture;
}

} // namespace vdblic
