#include "vdblic/methods/backward/cell_particles.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/vector.h"
#include "vdblic/methods/backward/way_back.h"
#include "vdblic/noise/noise.h"

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>

namespace vdblic {
namespace {

static_assert(CellParticles::kWhite == float(kNoiseMax));

constexpr float kRenewed = 0.1f; // share of the voxels without an arriving particle

/// An offset from a voxel's centre, to 1/254 of a voxel along each axis, as a whole number below 2²⁴.
constexpr int kOffsetBits = 8, kOffsetMask = (1 << kOffsetBits) - 1, kOffsetZero = 1 << (kOffsetBits - 1);
static_assert(CellParticles::kOffsetEnd == 1 << 3 * kOffsetBits);
constexpr float kOffsetSteps = 2 * (kOffsetZero - 1); // per voxel
constexpr int kNoOffset = (kOffsetZero << kOffsetBits | kOffsetZero) << kOffsetBits | kOffsetZero;

VDBLIC_INLINE Vector8 offsetsOf(Int8 packed)
{
    const auto along = [&](int axis) {
        const Int8 number = (packed >> (axis * kOffsetBits) & kOffsetMask) - kOffsetZero;
        return __builtin_convertvector(number, Float8) * (1 / kOffsetSteps);
    };
    return {along(0), along(1), along(2)};
}

/// @param offsets −½ to ½; others, from positions too far away, become 0
VDBLIC_INLINE Int8 packed(const Vector8& offsets)
{
    const auto along = [](Float8 offset) {
        const Int8 isInside = (offset >= -0.5f) & (offset <= 0.5f);
        const Float8 inside = isInside ? offset : Float8{};
        return floorToInt(inside * kOffsetSteps + 0.5f) + kOffsetZero;
    };
    return (along(offsets.z) << kOffsetBits | along(offsets.y)) << kOffsetBits | along(offsets.x);
}

VDBLIC_INLINE Float8 larger(Float8 a, Float8 b)
{
    return a > b ? a : b;
}

/// The voxel centres nearest to the vectors' ends.
VDBLIC_INLINE Vector8 voxelsOf(const Vector8& v)
{
    const auto along = [](Float8 x) { return __builtin_convertvector(floorToInt(x + 0.5f), Float8); };
    return {along(v.x), along(v.y), along(v.z)};
}

/// The particles nearest to eight positions, or voxel centres where there is none.
struct Nearest {
    Vector8 from;                        ///< the position to the particle
    Float8 distance = broadcast8(1e30f); ///< largest magnitude of a component of `from`
    Float8 value{};
};

/// A step. Immutable; any number of threads may use it.
struct Move {
    const Domain& domain; // of the first frame
    const CellParticles& before;
    const NoiseField& noise;
    std::uint64_t number;

    VDBLIC_INLINE void moveLeaf(const WayBack::Leaf& way, const Domain::Mask& mask, const openvdb::Coord& origin,
                                float* values, std::int32_t* offsets) const
    {
        const LeafWindow window(domain, origin);
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const unsigned lanes = mask.getWord<std::uint8_t>(openvdb::Index(row));
            if (lanes == 0) continue;
            const Vector8 position = way.row(row, lanes).before;
            Nearest nearest = nearestTo(window, position, lanes);
            const Int8 misses = (nearest.distance > 0.5f) & maskOf(lanes);
            if (anyOf(misses)) {
                const LeafVoxel first = LeafVoxel::ofRow(row);
                nearest.from = select(misses, nearest.from - voxelsOf(nearest.from), nearest.from);
                renew(origin + openvdb::Coord(first.x, first.y, 0), position, laneBits(misses), nearest.value);
            }
            const Float8 value = nearest.value;
            const Int8 offset = packed(nearest.from);
            storeRow(maskOf(lanes) ? value : Float8{}, values, row);
            storeRow(maskOf(lanes) ? offset : Int8{}, offsets, row);
        }
    }

    /// The particle nearest to each position, among those of its cell's corner voxels: only these can lie in the unit
    /// cube around it.
    VDBLIC_INLINE Nearest nearestTo(const LeafWindow& window, const Vector8& position, unsigned lanes) const
    {
        Nearest nearest{voxelsOf(position) - position};
        const Int8 x = floorToInt(position.x), y = floorToInt(position.y), z = floorToInt(position.z);
        for (int corner = 0; corner < 8; ++corner) {
            const auto next = [&](Int8 first, int bit) { return Int8(Unsigned8(first) + unsigned(corner >> bit & 1)); };
            const Int8 i = next(x, 2), j = next(y, 1), k = next(z, 0);
            Float8 value{};
            Int8 packedOffset{};
            load(window, i, j, k, lanes, value, packedOffset);
            const Vector8 offset = offsetsOf(packedOffset);
            const Vector8 from = {__builtin_convertvector(i, Float8) + offset.x - position.x,
                                  __builtin_convertvector(j, Float8) + offset.y - position.y,
                                  __builtin_convertvector(k, Float8) + offset.z - position.z};
            const auto size = [](Float8 part) { return part > 0 ? part : -part; };
            const Float8 distance = larger(larger(size(from.x), size(from.y)), size(from.z));
            const Int8 isCloser = (distance < nearest.distance) & (packedOffset != 0);
            nearest.from = select(isCloser, from, nearest.from);
            nearest.distance = isCloser ? distance : nearest.distance;
            nearest.value = isCloser ? value : nearest.value;
        }
        return nearest;
    }

    /// Load the particles of voxels; 0 where the domain has none.
    VDBLIC_INLINE void load(const LeafWindow& window, Int8 x, Int8 y, Int8 z, unsigned lanes, Float8& value,
                            Int8& offset) const
    {
        const Int8 slots = window.slots(x, y, z), at = LeafVoxel::offset(x, y, z);
        for (int lane = 0; lane < kLanes; ++lane) {
            if (!(lanes >> lane & 1)) continue;
            const int leaf = slots[lane] == LeafWindow::kElsewhere ? domain.findLeaf(Int4{x[lane], y[lane], z[lane], 0})
                                                                   : window.leaves[std::size_t(slots[lane])];
            if (leaf < 0) continue;
            value[lane] = before.values[std::size_t(leaf)][at[lane]];
            offset[lane] = before.offsets[std::size_t(leaf)][at[lane]];
        }
    }

    /// Give new noise to voxels without an arriving particle: to all whose fluid comes from outside, to a tenth of the
    /// others. @param row its first voxel
    void renew(const openvdb::Coord& row, const Vector8& positions, unsigned lanes, Float8& value) const
    {
        constexpr float kWhole = 1 - 1e-5f; // allows for the rounding of weights
        for (int lane = 0; lane < kLanes; ++lane) {
            if (!(lanes >> lane & 1)) continue;
            const openvdb::Coord voxel = row.offsetBy(0, 0, lane);
            float inside = 0;
            forCorners(domain, positions.lane(lane), [&](std::size_t, unsigned, float weight) { inside += weight; });
            if (inside >= kWhole && float(noise.ofStep(voxel, 2 * number + 1)) >= kRenewed * float(kNoiseMax)) continue;
            value[lane] = float(noise.ofStep(voxel, 2 * number));
        }
    }
};

VDBLIC_KERNEL void moveLeaf(const Move& move, const WayBack::Leaf& way, const Domain::Mask& mask,
                            const openvdb::Coord& origin, float* values, std::int32_t* offsets)
{
    move.moveLeaf(way, mask, origin, values, offsets);
}

} // namespace

CellParticles CellParticles::centred(const Domain& domain, const NoiseField& noise)
{
    CellParticles particles{noiseValues(domain, noise, domain.own()), {domain, 0, domain.own()}};
    forLeaves(domain.own(), [&](std::size_t leaf) {
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel)
            particles.offsets[leaf][voxel.pos()] = kNoOffset;
    });
    return particles;
}

CellParticles CellParticles::moved(const FlowStep& step, const NoiseField& noise, std::uint64_t number,
                                   const PathlineParams& pathline, StageClock& clock) const
{
    const Domain &first = *step.start.domain.texture, &last = *step.end.domain.texture;
    CellParticles result{{last, 0.0f, last.own()}, {last, 0, last.own()}};
    const Move move{first, *this, noise, number};
    WayBack way(step, pathline);
    tbb::enumerable_thread_specific<PathBatch> batches;
    const auto nothing = [](Slabs::Leaves) {};
    way.sweep(clock, nothing, nothing, [&](std::size_t leaf) {
        const LeafVelocities velocities = way.velocitiesOf(leaf);
        const WayBack::Leaf ways(way, leaf, velocities, batches.local());
        moveLeaf(move, ways, last.mask(leaf), last.origin(leaf), result.values[leaf], result.offsets[leaf]);
    });
    return result;
}

} // namespace vdblic
