#include "vdblic/methods/auflic/feedback.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/period_position.h"
#include "vdblic/field/slabs.h"
#include "vdblic/field/window_box.h"
#include "vdblic/lic/hits.h"
#include "vdblic/lic/leaf_velocities.h"
#include "vdblic/methods/auflic/local_contrast.h"
#include "vdblic/methods/auflic/release_turn.h"
#include "vdblic/methods/auflic/sharp_texture.h"
#include "vdblic/noise/noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {
namespace {

constexpr float kFullScale = float(kNoiseMax);
// The noise of entering fluid is correlated along streaks about as long as those inside the domain. A mean along such a
// streak keeps its deviation; of the inner noise, which changes from voxel to voxel, about this share remains.
constexpr int kFramesOfEntering = 2;
constexpr float kShareOfEntering = 0.4f;
constexpr float kUniformDeviation = 0.2887f; // standard deviation of uniform noise
constexpr float kMaxGain = 16;               // limits the amplification of regions without contrast

VDBLIC_INLINE Float8 clampToUnit(Float8 value)
{
    const Float8 atLeast0 = value > 0 ? value : Float8{};
    return atLeast0 < 1 ? atLeast0 : broadcast8(1);
}
VDBLIC_INLINE Int8 toFixed(Float8 value)
{
    return __builtin_convertvector(clampToUnit(value) * kFullScale + 0.5f, Int8);
}

/// The domain's share of the trilinear weights at a position.
float coverageAt(const Domain& domain, Float4 position)
{
    float coverage = 0;
    forCorners(domain, position, [&](std::size_t, unsigned, float weight) { coverage += weight; });
    return coverage;
}

/// For each leaf: whether all cells that begin in it lie inside the domain.
std::vector<std::uint8_t> leavesWithoutRim(const Domain& domain)
{
    std::vector<std::uint8_t> result(domain.leafCount());
    forLeaves(domain.local(), [&](std::size_t leaf) {
        const openvdb::Coord origin = domain.origin(leaf);
        bool whole = true;
        for (int corner = 0; whole && corner < 8; ++corner) {
            const Int4 step = {corner >> 2, corner >> 1 & 1, corner & 1, 0};
            const int there = domain.findLeaf(Int4{origin[0], origin[1], origin[2], 0} + step * LeafVoxel::kDim);
            whole = there >= 0 && domain.mask(std::size_t(there)).isOn();
        }
        result[leaf] = whole;
    });
    return result;
}

/// Computes the input of one leaf after another. Immutable; any number of threads may use it.
struct FeedForward {
    const VelocityField& field;
    const Domain& domain;
    const SharpTexture& sharp;
    const NoiseField& noise;
    const FeedbackParams& params;
    const std::vector<std::uint8_t>& withoutRim; // leavesWithoutRim()
    std::uint64_t step;
    float substeps;

    VDBLIC_INLINE void filterLeaf(std::size_t leaf, std::int32_t* input) const
    {
        const openvdb::Coord origin = domain.origin(leaf);
        const SharpTexture::Window window = sharp.window(origin);
        const Bricks::Window fieldWindow = field.window(origin);
        const LocalContrast::Leaf around(sharp.contrast(), origin);
        const WindowBox inside(domain, window.leaves);
        const LeafVelocities displacements(field.end(), field.frameDomain().refinement, origin);
        const Float8 midway = broadcast8(std::max(1 - 0.25f * substeps, 0.0f)); // a quarter of a frame back
        const Domain::Mask& mask = domain.mask(leaf);
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const unsigned lanes = mask.getWord<std::uint8_t>(openvdb::Index(row));
            if (lanes == 0) continue;
            const Vector8 last = displacements.row(row), displacement = last * substeps; // in a frame
            const LeafVoxel first = LeafVoxel::ofRow(row);
            const Vector8 centre = rowCentres(origin[0] + first.x, origin[1] + first.y, origin[2]);
            // Half a frame back by the midpoint rule.
            const Vector8 way =
                field.sample(fieldWindow, centre - displacement * 0.25f, midway, last, lanes) * substeps;
            const SharpTexture::Samples upstream = sharp.at(window, centre - way * 0.5f, lanes);
            const Int8 known = upstream.coverage > 0;
            const Float8 carried = anyOf(maskOf(lanes) & ~known)
                                       ? (known ? upstream.value : sharp.at(window, centre, lanes).value)
                                       : upstream.value;
            std::int32_t* const values = input + row * std::ptrdiff_t(LeafVoxel::kDim);
            Int8 value = filtered(around, first, carried, values);
            const Vector8 before = centre - displacement;
            const Int8 stayed = inside.holdsCell(floorToInt(before.x), floorToInt(before.y), floorToInt(before.z));
            const Int8 mayEnter = maskOf(lanes) & ~stayed;
            if (anyOf(mayEnter)) renewEntering(window, centre, before, laneBits(mayEnter), value);
            Int8 others;
            __builtin_memcpy(&others, values, sizeof others);
            value = maskOf(lanes) ? value : others;
            __builtin_memcpy(values, &value, sizeof value);
        }
    }

    /// Restore contrast and add noise. @param carried sharpened texture  @param first voxel of the row  @param input
    /// original noise of the row
    [[nodiscard]] VDBLIC_INLINE Int8 filtered(const LocalContrast::Leaf& around, LeafVoxel first, Float8 carried,
                                              const std::int32_t* input) const
    {
        Float8 original;
        for (int z = 0; z < LeafVoxel::kDim; ++z)
            original[z] = float(input[z]) / kFullScale;
        const LocalContrast::Row local = around.row(first.x, first.y);
        const Float8 least = broadcast8(params.deviation / kMaxGain);
        const Float8 gain = params.deviation / (local.deviation > least ? local.deviation : least);
        const Float8 restored = clampToUnit(0.5f + gain * (carried - local.mean));
        return toFixed(restored + params.noiseShare * (original - restored));
    }

    /// Give voxels whose fluid entered the domain during the frame the noise of that fluid.
    /// @param before positions a frame ago of the fluid at the voxels' centres
    /// @param lanes  of voxels whose fluid may have entered
    [[gnu::noinline]] void renewEntering(const SharpTexture::Window& window, const Vector8& centre,
                                         const Vector8& before, unsigned lanes, Int8& value) const
    {
        for (int z = 0; z < LeafVoxel::kDim; ++z) { // far upstream most fluid was still inside
            const int leaf = lanes >> z & 1 ? domain.findLeaf(floorToInt(before.lane(z))) : -1;
            if (leaf >= 0 && withoutRim[std::size_t(leaf)]) lanes &= ~(1u << z);
        }
        if (lanes == 0) return;
        const Float8 coverage = sharp.at(window, before, lanes).coverage;
        const Int8 slots = window.leaves.slots(floorToInt(before.x), floorToInt(before.y), floorToInt(before.z));
        for (int z = 0; z < LeafVoxel::kDim; ++z) {
            if (!(lanes >> z & 1)) continue;
            // Below the domain's first voxels bricks extrapolate their values, but such a position is outside.
            const bool inBrick = slots[z] == LeafWindow::kElsewhere ? domain.findLeaf(floorToInt(before.lane(z))) >= 0
                                                                    : window.leaves.leaves[std::size_t(slots[z])] >= 0;
            const float stayed = inBrick ? coverage[z] : coverageAt(domain, before.lane(z));
            const openvdb::Coord at(int(centre.x[z]), int(centre.y[z]), int(centre.z[z]));
            if (stayed < 1 && noise.fromOutside(at, step, stayed)) {
                const Entry entry = entryBetween(before.lane(z), centre.lane(z));
                const double time = double(step + 1) / double(substeps) - entry.age;
                const float gain = kShareOfEntering * params.deviation / kUniformDeviation;
                const float brought = 0.5f + gain * noise.entering(entry.voxel, time, kFramesOfEntering);
                value[z] = int(std::lround(std::clamp(brought, 0.0f, 1.0f) * kFullScale));
            }
        }
    }

    /// Where and when fluid entered the domain.
    struct Entry {
        openvdb::Coord voxel;
        float age; ///< part of a frame since the entry
    };
    /// @param from position a frame ago  @param to position now, inside the domain
    [[nodiscard]] Entry entryBetween(Float4 from, Float4 to) const
    {
        float inside = 0, outside = 1; // parts of a frame, back in time
        if (covers(domain, from)) {
            inside = 1;
        } else {
            const Float4 path = from - to;
            const float length = std::sqrt(path[0] * path[0] + path[1] * path[1] + path[2] * path[2]);
            constexpr float kResolution = 1.0f / 16; // voxels
            while ((outside - inside) * length > kResolution && outside - inside > 1e-6f) {
                const float middle = 0.5f * (inside + outside);
                (covers(domain, to + path * middle) ? inside : outside) = middle;
            }
        }
        const Int4 voxel = voxelOf(wrapped(domain.period(), to + (from - to) * inside));
        return {{voxel[0], voxel[1], voxel[2]}, inside};
    }
};

VDBLIC_KERNEL void filterLeaf(const FeedForward& filter, std::size_t leaf, std::int32_t* input)
{
    filter.filterLeaf(leaf, input);
}

} // namespace

LeafValues<std::int32_t> feedForward(VelocityField& field, const LeafValues<float>& texture, const Domain& next,
                                     const NoiseField& noise, const FeedbackParams& params, std::uint64_t step,
                                     int substeps)
{
    const Domain& domain = field.domain();
    const FrameDomain& sampled = field.sampledDomain();
    const Slabs slabs(domain, sampled.refinement), velocitySlabs(slabs, *sampled.velocity, sampled.refinement);
    SharpTexture sharp(field.frameDomain().texture, texture, params.sharpen, slabs);
    const std::vector<std::uint8_t> withoutRim = leavesWithoutRim(domain);
    const FeedForward filter{field, domain, sharp, noise, params, withoutRim, step, float(substeps)};

    LeafValues<std::int32_t> input = noiseInput(next, noise);
    // A sample lies up to a frame upstream; its cell, or the velocity's, extends one voxel farther.
    const float farthest = std::min(field.largest()[std::size_t(slabs.axis())] * float(substeps), 1e6f);
    const int cell = sampled.refinement.factors[std::size_t(slabs.axis())];
    const int reach = int(std::ceil((farthest + float(cell)) / float(LeafVoxel::kDim)));
    slabs.sweep(
        reach,
        [&](std::size_t slab) {
            sharp.open(slab);
            field.fill(velocitySlabs[slab]);
        },
        [&](std::size_t slab) {
            sharp.close(slab);
            field.release(velocitySlabs[slab]);
        },
        [&](std::size_t slab) {
            forLeaves(slabs[slab], [&](std::size_t leaf) {
                const openvdb::Coord origin = domain.origin(leaf);
                if (!domain.isOwn(leaf) || !isReleaseTurn(origin, step + 1, substeps)) return;
                const int to = next.findLeaf(Int4{origin[0], origin[1], origin[2], 0});
                if (to >= 0) filterLeaf(filter, leaf, input[std::size_t(to)]);
            });
        });
    return input;
}

} // namespace vdblic
