#include "vdblic/coherence/sparse_coherence.h"

#include "vdblic/coherence/correlation.h"
#include "vdblic/coherence/random_voxels.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/field/neighbourhood_grid.h"
#include "vdblic/field/position.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;

constexpr float kVisible = 0.15f;
constexpr float kHalf = 0.5f; // of a value: a smaller one is another streak
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr int kBlock = 512; // points: one sum for each block, so that additions have one order

/// One thread's view of a texture whose inactive voxels are 0.
class Values {
  public:
    explicit Values(const openvdb::FloatTree& tree) : mAccessor(tree) {}

    [[nodiscard]] float at(const Coord& voxel) const
    {
        float value = 0;
        return mAccessor.probeValue(voxel, value) ? value : 0.0f;
    }
    /// Trilinear.
    [[nodiscard]] float at(const Position<Space::kTexture>& position) const
    {
        const Int4 base = floorToInt(position.at);
        const Float4 share = position.at - __builtin_convertvector(base, Float4);
        float sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const int x = corner >> 2, y = corner >> 1 & 1, z = corner & 1;
            const float weight =
                (x ? share[0] : 1 - share[0]) * (y ? share[1] : 1 - share[1]) * (z ? share[2] : 1 - share[2]);
            sum += weight * at(Coord(base[0] + x, base[1] + y, base[2] + z));
        }
        return sum;
    }
    /// The largest value of the 27 voxels around a position.
    [[nodiscard]] float mostAround(const Position<Space::kTexture>& position) const
    {
        const Int4 nearest = floorToInt(position.at + 0.5f);
        float most = 0;
        for (int i = 0; i < 27; ++i)
            most =
                std::max(most, at(Coord(nearest[0] + i / 9 - 1, nearest[1] + i / 3 % 3 - 1, nearest[2] + i % 3 - 1)));
        return most;
    }

  private:
    openvdb::tree::ValueAccessor<const openvdb::FloatTree> mAccessor;
};

struct SparsePoint {
    Position<Space::kTexture> position;
    Float4 velocity; ///< voxels of the velocity per step
    float value;
};

struct SparseSums {
    std::size_t points = 0, rising = 0, arrived = 0, lost = 0;
    Correlation temporal, samePlace;

    void add(const SparseSums& other)
    {
        points += other.points;
        rising += other.rising;
        arrived += other.arrived;
        lost += other.lost;
        temporal.add(other.temporal);
        samePlace.add(other.samePlace);
    }
};

/// Evaluate `there` at the ends of pathlines. @param field of the step from the points' texture to `there`
void follow(const VelocityField& field, const CoherenceParams& params, const IndexSpaces& spaces, const Values& there,
            const std::vector<SparsePoint>& points, SparseSums& sums)
{
    PathBatch batch;
    const Bricks::Window anywhere;
    PathlineParams pathline = params.pathline;
    for (int axis = 0; axis < 3; ++axis) // the tolerance is in voxels of the texture
        pathline.tolerance = std::min(pathline.tolerance, params.pathline.tolerance * spaces.scale()[axis]);
    for (std::size_t first = 0; first < points.size(); first += kLanes) {
        const int count = int(std::min<std::size_t>(kLanes, points.size() - first));
        paging::breathe(std::size_t(count) * paging::kPointBytes);
        batch.lanes = (1u << count) - 1;
        for (int lane = 0; lane < count; ++lane) {
            const SparsePoint& point = points[first + std::size_t(lane)];
            batch.position.setLane(lane, spaces.velocity(point.position).at);
            batch.slope.setLane(lane, point.velocity);
        }
        advancePaths(field, anywhere, pathline, batch);
        for (int lane = 0; lane < count; ++lane) {
            const Position<Space::kVelocity> arrived{batch.position.lane(lane)};
            const bool isInside = covers(*field.frameDomain().velocity, arrived.at);
            if (!isInside || !(batch.arrived >> lane & 1)) continue;
            const SparsePoint& point = points[first + std::size_t(lane)];
            const Position<Space::kTexture> end = spaces.texture(arrived);
            ++sums.arrived;
            const float most = std::max(there.mostAround(end), there.mostAround(point.position));
            sums.lost += most < kHalf * point.value;
            sums.temporal.add(point.value, there.at(end));
            sums.samePlace.add(point.value, there.at(point.position));
        }
    }
}

/// Measure the visible voxels of moving fluid.
/// @param field velocity from the texture's time on, or against time  @param other texture at its end, or null
SparseSums measurePoints(const SparseTexture& texture, const SparseTexture* other, const VelocityField& field,
                         const CoherenceParams& params, std::int64_t frame)
{
    SparseSums all;
    if (texture.domain->voxelCount() == 0) return all;
    const IndexSpaces spaces(texture.refinement);
    const RandomVoxels voxels(*texture.domain, frame);
    std::vector<SparseSums> blocks((std::size_t(params.samples) + kBlock - 1) / kBlock);
    tbb::parallel_for(std::size_t(0), blocks.size(), [&](std::size_t block) {
        const Values values(*texture.values);
        SparseSums& sums = blocks[block];
        std::vector<SparsePoint> points;
        const std::size_t end = std::min((block + 1) * kBlock, std::size_t(params.samples));
        for (std::size_t i = block * kBlock; i < end; ++i) {
            paging::breathe(paging::kPointBytes);
            SparsePoint point{.position = {voxels.centre(voxels.hash(i))}, .velocity = {}, .value = 0};
            point.value = values.at(point.position);
            if (!(point.value > kVisible)) continue;
            point.velocity = field.sample(spaces.velocity(point.position).at, 0, Float4{});
            const Float4 slope = point.velocity * spaces.factor();
            const float speed = pathline::length(slope);
            if (!(speed >= 1)) continue;
            ++sums.points;
            sums.rising +=
                values.at({point.position.at + slope / speed}) > values.at({point.position.at - slope / speed});
            points.push_back(point);
        }
        if (other) follow(field, params, spaces, Values(*other->values), points, sums);
    });
    for (const SparseSums& block : blocks)
        all.add(block);
    return all;
}

struct Head {
    Coord voxel;
    float value;
};

/// The brightest voxels of heads, by leaf and voxel.
std::vector<Head> headsOf(const SparseTexture& texture, const VelocityField& field, const std::array<float, 3>& spacing)
{
    constexpr float kAhead = 0.25f;       // spacings: beyond the round end of a head
    constexpr float kAtMostAhead = 0.25f; // of a head's value
    constexpr float kBright = 0.3f;       // excludes heads that fade in or out
    const IndexSpaces spaces(texture.refinement);
    const Domain& domain = *texture.domain;
    Float4 ahead{};
    for (int axis = 0; axis < 3; ++axis)
        ahead[axis] = kAhead * spacing[std::size_t(axis)] * spaces.factor()[axis];
    std::vector<std::vector<Head>> found(domain.leafCount());
    tbb::parallel_for(std::size_t(0), domain.leafCount(), [&](std::size_t leaf) {
        const Values values(*texture.values);
        for (auto on = domain.mask(leaf).beginOn(); on; ++on) {
            const LeafVoxel inLeaf = LeafVoxel::at(on.pos());
            const Coord voxel = domain.origin(leaf).offsetBy(inLeaf.x, inLeaf.y, inLeaf.z);
            const float value = values.at(voxel);
            if (!(value > kBright)) continue;
            bool isMost = true;
            for (int i = 0; i < 27 && isMost; ++i) {
                const Coord other = voxel.offsetBy(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
                const float around = values.at(other);
                isMost = around < value || (around == value && !(other < voxel));
            }
            if (!isMost) continue;
            const Position<Space::kTexture> position{{float(voxel[0]), float(voxel[1]), float(voxel[2]), 0}};
            const Float4 slope = field.sample(spaces.velocity(position).at, 0, Float4{}) * spaces.factor();
            const float steps = pathline::length(slope / (ahead + Float4{0, 0, 0, 1}));
            if (!(steps > 0)) continue;
            const Float4 away = slope / steps;
            if (values.mostAround({position.at + away}) > kAtMostAhead * value) continue;
            if (values.mostAround({position.at - away}) > kHalf * value) found[leaf].push_back({voxel, value});
        }
    });
    std::vector<Head> heads;
    for (const std::vector<Head>& some : found)
        heads.insert(heads.end(), some.begin(), some.end());
    return heads;
}

constexpr float kOneHead = 0.3f; // spacings: maxima that are nearer belong to one head

/// The distances of heads to the next ones, 1 at most, ascending [spacings].
std::vector<float> distancesApart(std::vector<Head> heads, const SparseTexture& texture,
                                  const std::array<float, 3>& spacing)
{
    std::array<float, 3> voxels{}; // of a spacing
    for (std::size_t axis = 0; axis < 3; ++axis)
        voxels[axis] = spacing[axis] * float(texture.refinement.factors[axis]);
    const auto at = [&](const Head& head) {
        return std::array{float(head.voxel[0]), float(head.voxel[1]), float(head.voxel[2])};
    };
    const auto apart = [&](const Head& a, const Head& b) {
        float sum = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float along = float(a.voxel[axis] - b.voxel[axis]) / voxels[std::size_t(axis)];
            sum += along * along;
        }
        return std::sqrt(sum);
    };
    // The brightest of a cluster represents it.
    std::sort(heads.begin(), heads.end(), [](const Head& a, const Head& b) {
        return a.value > b.value || (a.value == b.value && a.voxel < b.voxel);
    });
    NeighbourhoodGrid grid(voxels);
    std::vector<Head> kept;
    const auto isAny = [](std::uint32_t) { return true; };
    for (const Head& head : heads) {
        if (NeighbourhoodGrid::Look(grid).anyWithin(at(head), kOneHead, isAny)) continue;
        grid.add(at(head), std::uint32_t(kept.size()));
        kept.push_back(head);
    }
    std::vector<float> nearest(kept.size(), 1.0f);
    tbb::parallel_for(std::size_t(0), kept.size(), [&](std::size_t i) {
        (void)NeighbourhoodGrid::Look(grid).anyWithin(at(kept[i]), 1, [&](std::uint32_t other) {
            if (other != i) nearest[i] = std::min(nearest[i], apart(kept[i], kept[other]));
            return false;
        });
    });
    std::sort(nearest.begin(), nearest.end());
    return nearest;
}

double share(std::size_t part, std::size_t of)
{
    return of == 0 ? kUnknown : double(part) / double(of);
}

} // namespace

SparseCoherence measureSparse(const SparseTexture& texture, const SparseTexture* next, const VelocityField& forward,
                              const VelocityField* backward, const CoherenceParams& params, std::int64_t frame)
{
    params.validate();
    const auto& factors = texture.refinement.factors;
    const std::size_t whole = forward.frameDomain().velocity->voxelCount() * std::size_t(factors[0]) *
                              std::size_t(factors[1]) * std::size_t(factors[2]);
    const SparseSums here = measurePoints(texture, next, forward, params, frame);
    SparseSums there;
    if (next && backward) there = measurePoints(*next, &texture, *backward, params, frame);
    SparseCoherence result{.frame = frame, .points = here.points, .figures = {}};
    SparseFigures& figures = result.figures;
    figures = {.held = share(texture.domain->voxelCount(), whole),
               .rising = share(here.rising, here.points),
               .temporal = here.temporal.value(),
               .samePlace = here.samePlace.value(),
               .vanishing = share(here.lost, here.arrived),
               .appearing = share(there.lost, there.arrived),
               .lowApart = kUnknown,
               .medianApart = kUnknown};
    if (!texture.spacing) return result;
    const std::vector<float> apart =
        distancesApart(headsOf(texture, forward, *texture.spacing), texture, *texture.spacing);
    result.heads = apart.size();
    if (apart.empty()) return result;
    figures.lowApart = double(apart[apart.size() / 100]);
    figures.medianApart = double(apart[apart.size() / 2]);
    return result;
}

} // namespace vdblic
