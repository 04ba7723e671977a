#include "vdblic/lic/steady_lic.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/hits.h"
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
    const LicKernel kernel;
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
                const float share =
                    kernel == LicKernel::kBox ? 1 : 0.5f + 0.5f * std::cos(std::numbers::pi_v<float> * s);
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

LeafValues<float> steadyLic(const FlowFrame& frame, const openvdb::Mat3d& toStep, int lifeSpan, LicKernel kernel,
                            const PathlineParams& pathline, const NoiseField& noise)
{
    const auto along = [&](double sign) {
        const VelocityLevel level{frame.velocities->tree(), toStep * (sign * 0.5 * lifeSpan)};
        VelocityField field;
        field.build(frame.fieldDomain(), level, level);
        return field;
    };
    const VelocityField downstream = along(1), upstream = along(-1);
    const LeafValues<std::int32_t> input = noiseInput(*frame.domain, noise, frame.domain->local());
    LeafValues<float> texture(*frame.domain, 0.0f);
    tbb::enumerable_thread_specific<Convolution> workers([&] { return Convolution{input, kernel, pathline}; });
    forLeaves(frame.domain->own(),
              [&](std::size_t leaf) { convolveLeaf(workers.local(), downstream, upstream, leaf, texture[leaf]); });
    return texture;
}

} // namespace vdblic
