#include "vdblic/methods/ibfv/ibfv_texture.h"

#include "vdblic/field/bricks.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/methods/backward/way_back.h"
#include "vdblic/methods/ibfv/periodic_noise.h"

#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace vdblic {
namespace {

constexpr int kMostPlaces = 16; // samples of noise along a step

/// Shares of the noise samples along a step, which together have the step's share.
class PlaceShares {
  public:
    explicit PlaceShares(double share)
    {
        for (int places = 1; places <= kMostPlaces; ++places)
            mShares[std::size_t(places)] = float(-std::expm1(std::log1p(-share) / places));
    }
    [[nodiscard]] VDBLIC_INLINE Float8 of(Int8 places) const
    {
        Float8 shares;
        for (int lane = 0; lane < kLanes; ++lane)
            shares[lane] = mShares[std::size_t(places[lane])];
        return shares;
    }
    [[nodiscard]] float of(int places) const { return mShares[std::size_t(places)]; }

  private:
    std::array<float, kMostPlaces + 1> mShares{};
};

/// The number of samples, at most the noise's spacing apart. @param length of the step [voxels]
VDBLIC_INLINE Int8 placesFor(Float8 length)
{
    constexpr auto kSpacing = float(PeriodicNoise::kSpacing);
    const Float8 bounded = length < kMostPlaces * kSpacing ? length : broadcast8(kMostPlaces * kSpacing);
    const Int8 places = -floorToInt(-bounded * (1 / kSpacing) + 1e-4f); // a length of the spacing is one step
    return places > 1 ? places : broadcastInt8(1);
}

/// Texture, coverage, noise and an unused number, at the first frame's voxels.
using CarriedBricks = BricksOf<4>;

VDBLIC_KERNEL void fillCarried(const Domain& domain, const LeafValues<float>& texture, const LeafWindow& window,
                               const float* noise, CarriedBricks::Record* records)
{
    for (int x = 0; x < CarriedBricks::kDim; ++x) {
        for (int y = 0; y < CarriedBricks::kDim; ++y) {
            const int slot = LeafWindow::slot(LeafVoxel::leafCoordinate(x) + 1, LeafVoxel::leafCoordinate(y) + 1, 1);
            const int row = LeafVoxel::row(x, y), first = CarriedBricks::index(x, y, 0);
            const int here = window.leaves[std::size_t(slot)], after = window.leaves[std::size_t(slot) + 1];
            const auto active = [&](int leaf) {
                return leaf < 0 ? 0u : domain.mask(std::size_t(leaf)).getWord<std::uint8_t>(openvdb::Index(row));
            };
            const Int8 has = maskOf(active(here));
            const Float8 coverage = has ? broadcast8(1) : Float8{};
            const Float8 values = here >= 0 && anyOf(has) ? loadRow(texture[std::size_t(here)], row) : Float8{};
            for (int z = 0; z < LeafVoxel::kDim; ++z)
                records[first + z] = {{values[z] * coverage[z], coverage[z], noise[first + z], 0}};
            const bool hasNext = (active(after) & 1) != 0;
            const float next = hasNext ? texture[std::size_t(after)][std::ptrdiff_t(LeafVoxel::kDim) * row] : 0.0f;
            records[first + LeafVoxel::kDim] = {{next, hasNext ? 1.0f : 0.0f, noise[first + LeafVoxel::kDim], 0}};
        }
    }
}

/// Add the texture of fluid that was outside a step ago, as if it had come straight at constant speed.
/// @param chord of the step, backwards  @param before texture there times coverage
VDBLIC_KERNEL void addEntering(const PlaceShares& shares, const PeriodicNoise& now, const Vector8& positions,
                               const Vector8& chords, const Int8& places, const Float8& coverage, unsigned lanes,
                               Float8& before)
{
    constexpr float kLeast = 1.0f / 8; // of the weights
    constexpr int kMost = 64;          // samples
    for (int lane = 0; lane < kLanes; ++lane) {
        if (!(lanes >> lane & 1)) continue;
        const float each = shares.of(places[lane]);
        const Float4 position = positions.lane(lane), chord = chords.lane(lane) * (1 / float(places[lane]));
        float sum = 0, weights = 0, weight = each;
        PeriodicNoise then = now;
        int left = 0; // samples until the previous step
        for (int place = 0; place < kMost && 1 - weights > kLeast; ++place) {
            if (left-- == 0) {
                then.goBack();
                left = places[lane] - 1;
            }
            sum += weight * then.at(position + chord * float(place));
            weights += weight;
            weight *= 1 - each;
        }
        before[lane] += (1 - coverage[lane]) * (sum / weights);
    }
}

/// Texture and coverage at positions whose cells begin outside the bricks, which extend half a voxel below the first
/// voxels.
void sampleCorners(const Domain& domain, const LeafValues<float>& texture, const Vector8& positions, unsigned lanes,
                   Float8 (&numbers)[4])
{
    for (int lane = 0; lane < kLanes; ++lane) {
        if (!(lanes >> lane & 1)) continue;
        numbers[0][lane] = numbers[1][lane] = 0;
        forCorners(domain, positions.lane(lane), [&](std::size_t leaf, unsigned offset, float weight) {
            numbers[0][lane] += weight * texture[leaf][offset];
            numbers[1][lane] += weight;
        });
    }
}

/// The noise at positions outside the bricks.
VDBLIC_KERNEL void noiseOutside(const PeriodicNoise& now, const Vector8& positions, unsigned lanes, Float8& values)
{
    for (int lane = 0; lane < kLanes; ++lane) {
        if (lanes >> lane & 1) values[lane] = now.at(positions.lane(lane));
    }
}

/// A step. Immutable; any number of threads may use it.
struct Blend {
    const Domain& domain; // of the first frame
    const LeafValues<float>& texture;
    const CarriedBricks& bricks;
    const PeriodicNoise& now; // at the second frame
    const PlaceShares& shares;
    float share;

    VDBLIC_INLINE void blendLeaf(const WayBack::Leaf& way, const Domain::Mask& mask, const openvdb::Coord& origin,
                                 const float* noiseHere, float* result) const
    {
        const CarriedBricks::Window window = bricks.window(origin);
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const unsigned lanes = mask.getWord<std::uint8_t>(openvdb::Index(row));
            if (lanes == 0) continue;
            const WayBack::Leaf::Row path = way.row(row, lanes);
            const LeafVoxel first = LeafVoxel::ofRow(row);
            Float8 brought;
            __builtin_memcpy(&brought, noiseHere + CarriedBricks::index(first.x, first.y, 0), sizeof brought);
            Float8 numbers[4];
            sample(window, path.before, lanes, numbers);
            const unsigned outside = withoutBrick(window, path.before, lanes);
            if (__builtin_expect(outside != 0, 0)) sampleCorners(domain, texture, path.before, outside, numbers);
            const Vector8 chord = path.before - path.centre;
            const Int8 places = placesFor(squareRoots(squaredLength(chord)));
            brought *= share;
            if (anyOf((places > 1) & maskOf(lanes))) alongTheWay(window, path, chord, places, lanes, brought);
            const Float8 coverage = numbers[1];
            constexpr float kWhole = 1 - 1e-5f; // allows for the rounding of weights
            const Int8 comes = (coverage < kWhole) & maskOf(lanes);
            Float8 before = numbers[0];
            if (__builtin_expect(anyOf(comes), 0)) {
                before = coverage > 0 ? before : Float8{};
                addEntering(shares, now, path.before, chord, places, coverage, laneBits(comes), before);
            } else {
                before /= coverage;
            }
            storeRow(maskOf(lanes) ? brought + before * (1 - share) : Float8{}, result, row);
        }
    }

    VDBLIC_INLINE void sample(const CarriedBricks::Window& window, const Vector8& position, unsigned lanes,
                              Float8 (&numbers)[4]) const
    {
        Float4 rows[8];
        bricks.interpolate(window, position, lanes, rows);
        transpose(rows, numbers);
    }

    /// The lanes of positions outside the window's bricks.
    [[nodiscard]] VDBLIC_INLINE static unsigned withoutBrick(const CarriedBricks::Window& window, const Vector8& at,
                                                             unsigned lanes)
    {
        const Int8 slots = window.leaves.slots(floorToInt(at.x), floorToInt(at.y), floorToInt(at.z));
        unsigned without = 0;
        for (int lane = 0; lane < kLanes; ++lane)
            without |= unsigned(window.bricks[std::size_t(slots[lane])] == nullptr) << lane;
        return without & lanes;
    }

    /// The noise sampled along the path. @param brought of the first sample, the voxel's centre
    VDBLIC_INLINE void alongTheWay(const CarriedBricks::Window& window, const WayBack::Leaf::Row& path,
                                   const Vector8& chord, Int8 places, unsigned lanes, Float8& brought) const
    {
        const Float8 each = shares.of(places), apart = 1 / __builtin_convertvector(places, Float8);
        Float8 weight = each;
        brought *= each / share;
        for (int place = 1; place < kMostPlaces; ++place) {
            const Int8 taken = (places > place) & maskOf(lanes);
            if (!anyOf(taken)) break;
            weight *= 1 - each;
            const Float8 part = apart * float(place); // of the step; the path is a parabola
            const Vector8 at = path.centre + path.slope * part + (chord - path.slope) * (part * part);
            Float8 numbers[4];
            sample(window, at, laneBits(taken), numbers);
            const unsigned outside = withoutBrick(window, at, laneBits(taken));
            if (__builtin_expect(outside != 0, 0)) noiseOutside(now, at, outside, numbers[2]);
            brought += taken ? weight * numbers[2] : Float8{};
        }
    }
};

/// The noise on a leaf of the second frame: from the bricks if the first frame has that leaf.
void noiseOf(const CarriedBricks& bricks, const PeriodicNoise& now, const openvdb::Coord& origin, float* values)
{
    const int leaf = bricks.domain().findLeaf(Int4{origin[0], origin[1], origin[2], 0});
    if (leaf < 0) {
        now.fill(origin, values);
        return;
    }
    const CarriedBricks::Record* const records = bricks.record(leaf, 0);
    for (int i = 0; i < CarriedBricks::kSize; ++i)
        values[i] = records[i].values[2];
}

VDBLIC_KERNEL void blendLeaf(const Blend& blend, const WayBack::Leaf& way, const Domain::Mask& mask,
                             const openvdb::Coord& origin, const float* noise, float* result)
{
    blend.blendLeaf(way, mask, origin, noise, result);
}

} // namespace

IbfvTexture::IbfvTexture(const TextureParams& texture, const BackwardParams& params, NoiseField noise)
    : BackwardTexture(texture, std::move(noise), {.particles = false, .texture = true}),
      mShare(params.stepShare(texture.lifeSpan, texture.substeps))
{
}

/// Noise, scaled to the contrast of later textures.
BackwardTexture::Carried IbfvTexture::first(const FlowStep& step) const
{
    const Domain& domain = *step.start.domain.texture;
    LeafValues<float> texture(domain, 0.0f, domain.own());
    const PeriodicNoise now(noise(), steps(), params().substeps, domain.period());
    const auto gain = float(std::sqrt(mShare / (2 - mShare)));
    forLeaves(domain.own(), [&](std::size_t leaf) {
        std::array<float, CarriedBricks::kSize> values;
        now.fill(domain.origin(leaf), values.data());
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const LeafVoxel at = LeafVoxel::at(voxel.pos());
            const float value = values[std::size_t(CarriedBricks::index(at.x, at.y, at.z))];
            texture[leaf][voxel.pos()] = 0.5f + gain * (value - 0.5f);
        }
    });
    return {{}, texture};
}

LeafValues<float> IbfvTexture::show(const FlowStep& /*step*/, const Carried& carried, StageClock& /*clock*/) const
{
    return carried.texture;
}

BackwardTexture::Carried IbfvTexture::pullBack(const FlowStep& step, const Carried& before, StageClock& clock) const
{
    const Domain &first = *step.start.domain.texture, &last = *step.end.domain.texture;
    const LeafValues<float>& texture = before.texture;
    LeafValues<float> result(last, 0.0f, last.own());
    const PeriodicNoise now(noise(), steps() + 1, params().substeps, last.period());
    CarriedBricks bricks;
    bricks.cover(step.start.domain.texture);
    const PlaceShares shares(mShare);
    const Blend blend{first, texture, bricks, now, shares, float(mShare)};
    WayBack way(step, params().pathline);
    tbb::enumerable_thread_specific<PathBatch> batches;
    way.sweep(
        clock,
        [&](Slabs::Leaves leaves) {
            bricks.fill(leaves, [&](std::size_t leaf, CarriedBricks::Record* records) {
                std::array<float, CarriedBricks::kSize> values;
                now.fill(first.origin(leaf), values.data());
                fillCarried(first, texture, LeafWindow(first, first.origin(leaf)), values.data(), records);
            });
        },
        [&](Slabs::Leaves leaves) { bricks.release(leaves); },
        [&](std::size_t leaf) {
            std::array<float, CarriedBricks::kSize> values;
            noiseOf(bricks, now, last.origin(leaf), values.data());
            const LeafVelocities velocities = way.velocitiesOf(leaf);
            const WayBack::Leaf ways(way, leaf, velocities, batches.local());
            blendLeaf(blend, ways, last.mask(leaf), last.origin(leaf), values.data(), result[leaf]);
        });
    return {{}, result};
}

} // namespace vdblic
