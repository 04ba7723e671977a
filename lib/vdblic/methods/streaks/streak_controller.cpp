#include "vdblic/methods/streaks/streak_controller.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/mix_bits.h"
#include "vdblic/field/neighbourhood_grid.h"

#include <openvdb/openvdb.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace vdblic {
namespace {

constexpr float kFree = 0.85f, kCrowded = 0.45f; // spacings

using Position = std::array<float, 3>;

const Position& headOf(const Streak& streak)
{
    return streak.path.back().position;
}

openvdb::Coord voxelAt(const Position& position)
{
    const Int4 voxel = voxelOf(Float4{position[0], position[1], position[2], 0});
    return {voxel[0], voxel[1], voxel[2]};
}

/// Random places in cells of one spacing. A cell is cut where the domain is thinner or ends in it.
class Cells {
  public:
    Cells(const Position& spacing, const openvdb::CoordBBox& box, std::uint64_t key)
        : mSpacing(spacing), mBox(box), mKey(key)
    {
    }

    [[nodiscard]] int cellOf(float coordinate, std::size_t axis) const
    {
        return int(std::floor(coordinate / mSpacing[axis]));
    }

    [[nodiscard]] StreakPlace place(const openvdb::Coord& cell) const
    {
        std::uint64_t name = mKey;
        for (int axis = 0; axis < 3; ++axis)
            name = mixBits(name + std::uint32_t(cell[axis]));
        StreakPlace place{{}, name};
        for (int axis = 0; axis < 3; ++axis) {
            const auto at = std::size_t(axis);
            const float low = float(mBox.min()[axis]) - 0.5f, high = float(mBox.max()[axis]) + 0.5f;
            const float first = std::max(float(cell[axis]) * mSpacing[at], low);
            const float last = std::min((float(cell[axis]) + 1) * mSpacing[at], high);
            const auto share = float(double(mixBits(name + 2 + at) >> 40) * 0x1p-24);
            place.position[at] = high - low <= mSpacing[at] ? 0.5f * (low + high) : first + (last - first) * share;
        }
        return place;
    }

  private:
    Position mSpacing;
    openvdb::CoordBBox mBox;
    std::uint64_t mKey;
};

/// Add the places in a leaf of the region.
void addPlaces(const Cells& cells, const openvdb::MaskTree& domain, const Domain& region, std::size_t leaf,
               std::vector<StreakPlace>& places)
{
    const openvdb::Coord origin = region.origin(leaf);
    openvdb::Coord first, last;
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = std::size_t(axis);
        first[axis] = cells.cellOf(float(origin[axis]) - 0.5f, at);
        last[axis] = cells.cellOf(float(origin[axis] + LeafVoxel::kDim) - 0.5f, at);
    }
    for (openvdb::CoordBBox::Iterator<true> cell(openvdb::CoordBBox(first, last)); cell; ++cell) {
        const StreakPlace place = cells.place(*cell);
        const openvdb::Coord voxel = voxelAt(place.position);
        if ((voxel & ~(LeafVoxel::kDim - 1)) != origin) continue; // in another leaf
        if (region.mask(leaf).isOn(openvdb::MaskTree::LeafNodeType::coordToOffset(voxel)) && domain.isValueOn(voxel))
            places.push_back(place);
    }
}

} // namespace

std::size_t retireCrowded(std::vector<Streak>& streaks, const std::array<float, 3>& spacing, double time,
                          const Period& period)
{
    NeighbourhoodGrid grid(spacing, period);
    std::vector<std::uint32_t> live;
    for (std::uint32_t i = 0; i < streaks.size(); ++i) {
        if (!streaks[i].isLive()) continue;
        grid.add(headOf(streaks[i]), i);
        live.push_back(i);
    }
    const auto isOlder = [&](std::uint32_t a, std::uint32_t b) {
        return std::tie(streaks[a].born, streaks[a].name) < std::tie(streaks[b].born, streaks[b].name);
    };
    std::vector<std::uint8_t> isContested(live.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, live.size()), [&](const auto& range) {
        const NeighbourhoodGrid::Look look(grid);
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            isContested[i] = look.anyWithin(headOf(streaks[live[i]]), kCrowded,
                                            [&](std::uint32_t other) { return isOlder(other, live[i]); });
    });
    std::vector<std::uint32_t> contested;
    for (std::size_t i = 0; i < live.size(); ++i) {
        if (isContested[i]) contested.push_back(live[i]);
    }
    std::sort(contested.begin(), contested.end(), isOlder);
    const NeighbourhoodGrid::Look look(grid);
    std::size_t retired = 0;
    for (const std::uint32_t i : contested) {
        const bool isCrowded = look.anyWithin(headOf(streaks[i]), kCrowded, [&](std::uint32_t other) {
            return streaks[other].isLive() && isOlder(other, i);
        });
        if (!isCrowded) continue;
        streaks[i].retired = time;
        ++retired;
    }
    return retired;
}

std::vector<StreakPlace> freePlaces(const std::vector<Streak>& streaks, const std::array<float, 3>& spacing,
                                    const Domain& domain, const Domain& region, std::uint32_t seed, std::uint64_t turn)
{
    NeighbourhoodGrid grid(spacing, domain.period());
    for (std::uint32_t i = 0; i < streaks.size(); ++i) {
        if (streaks[i].isLive()) grid.add(headOf(streaks[i]), i);
    }
    openvdb::CoordBBox box;
    domain.topology().evalActiveVoxelBoundingBox(box);
    const Cells cells(spacing, box, mixBits(mixBits(seed + 0x9e3779b97f4a7c15u) + turn));
    std::vector<std::vector<StreakPlace>> ofLeaves(region.leafCount());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, region.leafCount()), [&](const auto& range) {
        const NeighbourhoodGrid::Look look(grid);
        for (std::size_t leaf = range.begin(); leaf < range.end(); ++leaf) {
            addPlaces(cells, domain.topology(), region, leaf, ofLeaves[leaf]);
            std::erase_if(ofLeaves[leaf], [&](const StreakPlace& place) {
                return look.anyWithin(place.position, kFree, [](std::uint32_t) { return true; });
            });
        }
    });
    std::vector<StreakPlace> places, free;
    for (const std::vector<StreakPlace>& some : ofLeaves)
        places.insert(places.end(), some.begin(), some.end());
    std::sort(places.begin(), places.end(), [](const StreakPlace& a, const StreakPlace& b) { return a.name < b.name; });
    NeighbourhoodGrid taken(spacing, domain.period());
    for (const StreakPlace& place : places) {
        const bool isTaken =
            NeighbourhoodGrid::Look(taken).anyWithin(place.position, kFree, [](std::uint32_t) { return true; });
        if (isTaken) continue;
        taken.add(place.position, std::uint32_t(free.size()));
        free.push_back(place);
    }
    return free;
}

} // namespace vdblic
