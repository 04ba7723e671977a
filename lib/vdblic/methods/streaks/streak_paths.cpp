#include "vdblic/methods/streaks/streak_paths.h"

#include "vdblic/core/message.h"
#include "vdblic/field/bricks.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/period_position.h"
#include "vdblic/field/vector.h"
#include "vdblic/lic/pathline.h"

#include <openvdb/openvdb.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace vdblic {
namespace {

using Position = std::array<float, 3>;

Float4 vectorOf(const Position& position)
{
    return Float4{position[0], position[1], position[2], 0};
}
Position positionOf(Float4 vector)
{
    return {vector[0], vector[1], vector[2]};
}

/// The streaks in this rank's own leaves, leaf by leaf, so that those advanced together sample the same bricks.
std::vector<std::uint32_t> ownByLeaf(const Domain& domain, const std::vector<Streak>& streaks)
{
    std::vector<int> leaves(streaks.size(), -1);
    tbb::parallel_for(std::size_t(0), streaks.size(), [&](std::size_t i) {
        if (!streaks[i].isStopped) leaves[i] = domain.findLeaf(voxelOf(vectorOf(streaks[i].path.back().position)));
    });
    std::vector<std::pair<int, std::uint32_t>> own;
    for (std::uint32_t i = 0; i < streaks.size(); ++i) {
        if (leaves[i] >= 0 && domain.isOwn(std::size_t(leaves[i]))) own.emplace_back(leaves[i], i);
    }
    std::sort(own.begin(), own.end());
    std::vector<std::uint32_t> numbers(own.size());
    std::transform(own.begin(), own.end(), numbers.begin(), [](const auto& one) { return one.second; });
    return numbers;
}

/// Advance up to eight streaks. @param numbers of the streaks  @return integration steps
VDBLIC_KERNEL std::size_t advanceBatch(const StreakTurn& turn, const PathlineParams& params,
                                       const std::uint32_t* numbers, int count, PathBatch& batch,
                                       std::vector<Streak>& streaks)
{
    const VelocityField& field = turn.field;
    batch.lanes = (1u << count) - 1;
    batch.steps = 0;
    for (int i = 0; i < kLanes; ++i)
        batch.position.setLane(i, vectorOf(streaks[numbers[i < count ? i : 0]].path.back().position));
    const Int4 voxel = voxelOf(batch.position.lane(0));
    constexpr int kInLeaf = LeafVoxel::kDim - 1;
    const Bricks::Window window = field.window({voxel[0] & ~kInLeaf, voxel[1] & ~kInLeaf, voxel[2] & ~kInLeaf});
    batch.slope = field.sample(window, batch.position, broadcast8(turn.from), Vector8{}, batch.lanes);
    advancePaths(field, window, params, batch, turn.from, turn.to);
    for (const Segment& segment : batch.segments) {
        for (int i = 0; i < count; ++i) {
            if (!(segment.lanes >> i & 1)) continue;
            const bool isLast = (batch.arrived >> i & 1) && segment.time[i] + segment.duration[i] >= turn.to;
            const double time = isLast ? turn.endTime() : turn.frame + double(segment.time[i] + segment.duration[i]);
            streaks[numbers[i]].path.push_back(
                {positionOf(segment.end.lane(i)), positionOf(segment.endSlope.lane(i)), time});
        }
    }
    return batch.steps;
}

/// Traces a path back in time from the end of a turn.
class BackwardPath {
  public:
    /// @param region the path ends at its rims
    BackwardPath(const StreakTurn& turn, const PathlineParams& params, const Domain& region)
        : mTurn(turn), mTolerance(params.tolerance), mRegion(region)
    {
    }

    /// @param duration of the path [frames]; isFrozen: whether the flow is that of the turn's beginning
    /// @return its nodes, oldest first, and whether it entered over a rim
    [[nodiscard]] std::pair<std::vector<StreakNode>, bool> trace(const Position& place, double duration,
                                                                 bool isFrozen) const
    {
        const auto velocity = [&](Float4 position, double ago, Float4 other) {
            const double fraction = isFrozen ? double(mTurn.from) : double(mTurn.to) - ago;
            return mTurn.field.sample(position, float(fraction), other);
        };
        Float4 at = vectorOf(place), slope = velocity(at, 0, Float4{});
        std::vector<StreakNode> nodes = {{place, positionOf(slope), mTurn.endTime()}};
        bool cameIn = false;
        double ago = 0, step = duration;
        for (int tries = 0; ago < duration && tries < kMostTries; ++tries) {
            step = std::min({step, duration - ago, kStride / std::max(double(pathline::length(slope)), 1e-9)});
            const auto h = float(step);
            const Float4 k2 = velocity(at - slope * (0.5f * h), ago + 0.5 * step, slope);
            const Float4 k3 = velocity(at - k2 * (0.5f * h), ago + 0.5 * step, k2);
            const Float4 k4 = velocity(at - k3 * h, ago + step, k3);
            const Float4 next = at - (slope + (k2 + k3) * 2.0f + k4) * (h / 6);
            const Float4 k5 = velocity(next, ago + step, k4);
            const float error = h / 6 * pathline::length(k4 - k5);
            if (error > mTolerance && step > kShortest) {
                step *= 0.5;
                continue;
            }
            if (!contains(next)) {
                cameIn = true;
                if (step * double(pathline::length(slope)) <= kRim || step <= kShortest) break;
                step *= 0.5; // bisect the rest up to the rim
                continue;
            }
            at = next;
            slope = k5;
            ago += step;
            nodes.push_back({positionOf(at), positionOf(slope), mTurn.endTime() - ago});
            if (!cameIn) step = std::min(2 * step, duration);
        }
        if (cameIn) nodes.push_back(behindRim(nodes.back()));
        std::reverse(nodes.begin(), nodes.end());
        return {std::move(nodes), cameIn};
    }

  private:
    static constexpr double kStride = 4, kRim = 1.0 / 16; // voxels
    static constexpr double kShortest = 1e-5;             // frames
    static constexpr int kMostTries = 2000;

    /// A point of the path a streak's reach before its entry, so that its round head slides in too.
    [[nodiscard]] StreakNode behindRim(const StreakNode& rim) const
    {
        constexpr double kLongest = 1; // frame
        StreakNode behind = rim;
        const double speed = double(pathline::length(vectorOf(rim.slope)));
        const double duration = std::min(double(mTurn.reach) / std::max(speed, 1e-9), kLongest);
        for (std::size_t axis = 0; axis < 3; ++axis)
            behind.position[axis] -= rim.slope[axis] * float(duration);
        behind.time -= duration;
        return behind;
    }

    [[nodiscard]] bool contains(Float4 position) const
    {
        const Int4 voxel = voxelOf(position);
        const Period& period = mTurn.field.domain().period();
        return mRegion.topology().isValueOn(period.wrapped(openvdb::Coord(voxel[0], voxel[1], voxel[2])));
    }

    const StreakTurn& mTurn;
    float mTolerance;
    const Domain& mRegion;
};

/// Move a path so that its head is in a periodic box.
void moveIntoBox(const Period& period, std::vector<StreakNode>& path)
{
    const Position head = path.back().position, in = positionOf(wrapped(period, vectorOf(head)));
    if (in == head) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (in[axis] == head[axis]) continue;
        const auto size = float(period.size[int(axis)]);
        const float way = std::round((in[axis] - head[axis]) / size) * size;
        for (StreakNode& node : path)
            node.position[axis] += way;
    }
    path.back().position = in;
}

void putNodes(Exchange::Bytes& message, std::uint32_t number, const StreakNode* nodes, std::size_t count)
{
    put(message, number);
    put(message, std::uint32_t(count));
    put(message, nodes, count);
}

/// Receive the nodes of other ranks: take(number, nodes). @param message of this rank. Collective.
template<typename Take>
void swapNodes(const LeafOwners& owners, const Exchange::Bytes& message, const Take& take)
{
    for (const Exchange::Bytes& bytes : owners.tell(message)) {
        for (MessageReader reader(bytes); !reader.atEnd();) {
            const auto number = reader.get<std::uint32_t>();
            std::vector<StreakNode> nodes(reader.get<std::uint32_t>());
            reader.get(nodes.data(), nodes.size());
            take(number, std::move(nodes));
        }
    }
}

/// @param duration, isFrozen of BackwardPath::trace()
void addTraced(const StreakTurn& turn, const PathlineParams& params, const Domain& region, double duration,
               bool isFrozen, const std::vector<StreakPlace>& places, const LeafOwners& owners,
               std::vector<Streak>& streaks)
{
    const std::size_t before = streaks.size();
    for (const StreakPlace& place : places)
        streaks.push_back({.name = place.name, .born = turn.endTime()});
    const Domain& domain = turn.field.domain();
    const BackwardPath backward(turn, params, region);
    const auto isOurs = [&](const StreakPlace& place) {
        const int leaf = domain.findLeaf(voxelOf(vectorOf(place.position)));
        return leaf >= 0 && domain.isOwn(std::size_t(leaf));
    };
    const auto take = [&](std::size_t place, std::vector<StreakNode> nodes, bool cameIn) {
        Streak& streak = streaks[before + place];
        if (!cameIn && !isFrozen) nodes.erase(nodes.begin(), nodes.end() - 1);
        // Pictures before the frame do not show it: if it would have been in sight, it fades in.
        const bool comesIntoSight = nodes.front().time >= turn.frame;
        streak.slidIn = isFrozen || (cameIn && comesIntoSight);
        if (streak.slidIn)
            streak.born = nodes.front().time;
        else if (cameIn)
            streak.born = turn.frame;
        streak.path = std::move(nodes);
    };
    std::vector<std::uint8_t> cameIn(places.size());
    tbb::parallel_for(std::size_t(0), places.size(), [&](std::size_t i) {
        if (!isOurs(places[i])) return;
        auto [nodes, came] = backward.trace(places[i].position, duration, isFrozen);
        cameIn[i] = came ? 1 : 0;
        take(i, std::move(nodes), came);
    });
    if (owners.areSeveral()) {
        Exchange::Bytes message;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const std::vector<StreakNode>& path = streaks[before + i].path;
            if (!path.empty()) putNodes(message, std::uint32_t(2 * i + cameIn[i]), path.data(), path.size());
        }
        swapNodes(owners, message, [&](std::uint32_t number, std::vector<StreakNode> nodes) {
            take(number / 2, std::move(nodes), number % 2 != 0);
        });
    }
    // Only the end of the turn contains the place: no velocity leads to it.
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (streaks[before + i].path.empty()) take(i, {{places[i].position, {}, turn.endTime()}}, false);
    }
}

} // namespace

std::size_t advanceStreaks(const StreakTurn& turn, const PathlineParams& params, const LeafOwners& owners,
                           std::vector<Streak>& streaks)
{
    const std::vector<std::uint32_t> own = ownByLeaf(turn.field.domain(), streaks);
    std::vector<std::size_t> lengths(owners.areSeveral() ? own.size() : 0);
    for (std::size_t i = 0; i < lengths.size(); ++i)
        lengths[i] = streaks[own[i]].path.size();
    tbb::enumerable_thread_specific<PathBatch> batches;
    tbb::enumerable_thread_specific<std::size_t> steps;
    tbb::parallel_for(std::size_t(0), (own.size() + kLanes - 1) / kLanes, [&](std::size_t i) {
        const std::size_t first = i * kLanes;
        const int count = int(std::min(own.size() - first, std::size_t(kLanes)));
        steps.local() += advanceBatch(turn, params, own.data() + first, count, batches.local(), streaks);
    });
    if (owners.areSeveral()) {
        Exchange::Bytes message;
        for (std::size_t i = 0; i < own.size(); ++i) {
            const std::vector<StreakNode>& path = streaks[own[i]].path;
            putNodes(message, own[i], path.data() + lengths[i], path.size() - lengths[i]);
        }
        std::vector<std::uint8_t> isOwn(streaks.size());
        for (const std::uint32_t number : own)
            isOwn[number] = 1;
        swapNodes(owners, message, [&](std::uint32_t number, const std::vector<StreakNode>& nodes) {
            std::vector<StreakNode>& path = streaks[number].path;
            if (!isOwn[number]) path.insert(path.end(), nodes.begin(), nodes.end());
        });
    }
    tbb::parallel_for(std::size_t(0), streaks.size(), [&](std::size_t i) {
        Streak& streak = streaks[i];
        moveIntoBox(turn.field.domain().period(), streak.path);
        const StreakNode& head = streak.path.back();
        const Int4 voxel = voxelOf(vectorOf(head.position));
        if (head.time < turn.endTime() || !turn.end.topology().isValueOn({voxel[0], voxel[1], voxel[2]}))
            streak.isStopped = true;
    });
    std::size_t sum = 0;
    for (const std::size_t some : steps)
        sum += some;
    return sum;
}

void addStreaks(const StreakTurn& turn, const PathlineParams& params, const Domain& region,
                const std::vector<StreakPlace>& places, const LeafOwners& owners, std::vector<Streak>& streaks)
{
    addTraced(turn, params, region, double(turn.to) - double(turn.from), false, places, owners, streaks);
}

void addFirstStreaks(const StreakTurn& turn, const PathlineParams& params, const Domain& region, double tail,
                     const std::vector<StreakPlace>& places, const LeafOwners& owners, std::vector<Streak>& streaks)
{
    addTraced(turn, params, region, tail, true, places, owners, streaks);
}

} // namespace vdblic
