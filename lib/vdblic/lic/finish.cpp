#include "vdblic/lic/finish.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/slabs.h"
#include "vdblic/lic/leaf_velocities.h"
#include "vdblic/lic/sharpen.h"
#include "vdblic/lic/texture_bricks.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace vdblic {
namespace {

/// Takes means along the flow. Immutable; any number of threads may use it.
struct MeanAlong {
    const VelocityLevel& velocities;
    const Refinement& refinement;
    const Domain& domain;
    const TextureBricks& texture;
    int taps;

    VDBLIC_INLINE void filterLeaf(std::size_t leaf, float* values) const
    {
        const openvdb::Coord origin = domain.origin(leaf);
        const LeafWindow window(domain, origin);
        const LeafVelocities displacements(velocities, refinement, origin);
        const Domain::Mask& mask = domain.mask(leaf);
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const unsigned lanes = mask.getWord<std::uint8_t>(openvdb::Index(row));
            if (lanes == 0) continue;
            const LeafVoxel first = LeafVoxel::ofRow(row);
            const Vector8 direction = unit(displacements.row(row));
            Vector8 centre;
            centre.x = broadcast8(float(origin[0] + first.x));
            centre.y = broadcast8(float(origin[1] + first.y));
            centre.z = Float8{0, 1, 2, 3, 4, 5, 6, 7} + float(origin[2]);
            Float8 sum{}, weights{};
            for (int tap = -taps; tap <= taps; ++tap) {
                const TextureBricks::Samples there = texture.at(window, centre + direction * float(tap), lanes);
                const auto weight = float(taps + 1 - std::abs(tap));
                const Int8 inside = there.coverage > 0;
                sum += inside ? there.texture * weight : Float8{};
                weights += inside ? broadcast8(weight) : Float8{};
            }
            const Float8 mean = sum / weights; // the voxel's own tap is always inside
            for (int z = 0; z < LeafVoxel::kDim; ++z) {
                if (lanes >> z & 1) values[LeafVoxel::kDim * row + z] = mean[z];
            }
        }
    }

    /// Of length 1, or 0 where there is no motion.
    [[nodiscard]] VDBLIC_INLINE static Vector8 unit(const Vector8& v)
    {
        const Float8 squared = v.x * v.x + v.y * v.y + v.z * v.z;
        constexpr float kLeast = 1e-12f;
        const Float8 length = squareRoots(squared > kLeast ? squared : broadcast8(kLeast));
        const Float8 scale = squared > kLeast ? 1 / length : Float8{};
        return {v.x * scale, v.y * scale, v.z * scale};
    }
};

VDBLIC_KERNEL void meanAlongLeaf(const MeanAlong& filter, std::size_t leaf, float* values)
{
    filter.filterLeaf(leaf, values);
}

} // namespace

void FinishParams::validate() const
{
    constexpr int kMost = 8; // taps stay within the next leaf
    if (taps < 0 || taps > kMost) {
        throw ParameterError(fmt::format("`finish` {} must lie between 0 and {} voxels", taps, kMost));
    }
}

LeafValues<float> finished(const FlowFrame& frame, const openvdb::Mat3d& toStep, const LeafValues<float>& texture,
                           const FinishParams& params)
{
    if (params.taps == 0) return texture;
    const Domain& domain = *frame.domain;
    openvdb::Mat3d toTexture = openvdb::Mat3d::identity();
    for (int axis = 0; axis < 3; ++axis)
        toTexture(axis, axis) = frame.refinement.factors[std::size_t(axis)];
    const VelocityLevel velocities{frame.velocities->tree(), toTexture * toStep};
    TextureBricks bricks(frame.domain, texture, texture);
    const MeanAlong filter{velocities, frame.refinement, domain, bricks, params.taps};
    LeafValues<float> mean(domain, 0.0f);
    const Slabs slabs(domain);
    slabs.sweep(
        1, [&](std::size_t slab) { bricks.fill(slabs[slab]); }, [&](std::size_t slab) { bricks.release(slabs[slab]); },
        [&](std::size_t slab) {
            const Slabs::Leaves leaves = slabs[slab];
            tbb::parallel_for(std::size_t(0), leaves.size(),
                              [&](std::size_t i) { meanAlongLeaf(filter, leaves[i], mean[leaves[i]]); });
        });
    LeafValues<float> result = sharpened(domain, mean, params.sharpen);
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        for (int i = 0; i < LeafVoxel::kCount; ++i)
            result[leaf][i] = std::clamp(result[leaf][i], 0.0f, 1.0f);
    });
    return result;
}

} // namespace vdblic
