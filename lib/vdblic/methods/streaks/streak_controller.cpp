#include "vdblic/methods/streaks/streak_controller.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/mix_bits.h"

#include <openvdb/openvdb.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

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

void addLive(const std::vector<Streak>& streaks, std::size_t first, NeighbourhoodGrid& heads)
{
    for (std::size_t i = first; i < streaks.size(); ++i) {
        if (streaks[i].isLive()) heads.add(headOf(streaks[i]), std::uint32_t(i));
    }
}

std::size_t retireCrowded(std::vector<Streak>& streaks, const NeighbourhoodGrid& heads, double time)
{
    const auto isOlder = [&](std::uint32_t a, std::uint32_t b) {
        return std::tie(streaks[a].born, streaks[a].name) < std::tie(streaks[b].born, streaks[b].name);
    };
    std::vector<std::uint8_t> isContested(streaks.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, streaks.size()), [&](const auto& range) {
        const NeighbourhoodGrid::Look look(heads);
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            isContested[i] = streaks[i].isLive() &&
                             look.anyWithin(headOf(streaks[i]), kCrowded,
                                            [&](std::uint32_t other) { return isOlder(other, std::uint32_t(i)); });
        }
    });
    std::vector<std::uint32_t> contested;
    for (std::uint32_t i = 0; i < streaks.size(); ++i) {
        if (isContested[i]) contested.push_back(i);
    }
    std::sort(contested.begin(), contested.end(), isOlder);
    const NeighbourhoodGrid::Look look(heads);
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

std::vector<StreakPlace> freePlaces(const std::vector<Streak>& streaks, const NeighbourhoodGrid& heads,
                                    const std::array<float, 3>& spacing, const Domain& domain, const Domain& region,
                                    std::uint32_t seed, std::uint64_t turn)
{
    openvdb::CoordBBox box;
    domain.topology().evalActiveVoxelBoundingBox(box);
    const Cells cells(spacing, box, mixBits(mixBits(seed + 0x9e3779b97f4a7c15u) + turn));
    std::vector<std::vector<StreakPlace>> ofLeaves(region.leafCount());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, region.leafCount()), [&](const auto& range) {
        const NeighbourhoodGrid::Look look(heads);
        for (std::size_t leaf = range.begin(); leaf < range.end(); ++leaf) {
            addPlaces(cells, domain.topology(), region, leaf, ofLeaves[leaf]);
            std::erase_if(ofLeaves[leaf], [&](const StreakPlace& place) {
                return look.anyWithin(place.position, kFree, [&](std::uint32_t i) { return streaks[i].isLive(); });
            });
        }
    });
    std::vector<StreakPlace> places, free;
    for (const std::vector<StreakPlace>& some : ofLeaves)
        places.insert(places.end(), some.begin(), some.end());
    std::vector<std::pair<std::uint64_t, std::uint32_t>> byName(places.size());
    for (std::uint32_t i = 0; i < places.size(); ++i)
        byName[i] = {places[i].name, i};
    tbb::parallel_sort(byName);
    NeighbourhoodGrid taken(spacing, domain.period());
    const NeighbourhoodGrid::Look look(taken);
    std::vector<std::uint8_t> isFree(places.size());
    for (const auto& [name, i] : byName) {
        if (look.anyWithin(places[i].position, kFree, [](std::uint32_t) { return true; })) continue;
        taken.add(places[i].position, i);
        isFree[i] = 1;
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (isFree[i]) free.push_back(places[i]);
    }
    return free;
}

} // namespace vdblic
