#include "vdblic/methods/streaks/streak_lines.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/methods/streaks/streak_pieces.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// A point of a pathline.
struct Sample {
    openvdb::Vec3f position; // index space of the velocity
    double time;
};
using Samples = std::vector<Sample>;

/// A line: a part of a tail.
struct Part {
    bool isRest; // whether it does not end at the head
    std::uint64_t name;
    std::size_t begin, end; // in `samples`
    const Samples* samples;
    const Streak* streak;

    /// Heads first: their numbers are the same in all frames. Then by name: a resumed run has another order.
    bool operator<(const Part& other) const
    {
        return std::tie(isRest, name, begin) < std::tie(other.isRest, other.name, other.begin);
    }
};

/// The lines of some streaks.
struct Block {
    Samples samples;
    std::vector<Part> parts;
};

/// Samples tails of streaks, from their ends to the heads.
class TailSampler {
  public:
    TailSampler(const StreakShape& shape, const Domain& domain, double time)
        : mDomain(domain), mTime(time), mTail(double(shape.tail))
    {
        float radius = std::numeric_limits<float>::max();
        for (int axis = 0; axis < 3; ++axis)
            radius = std::min(radius, shape.radius(axis) / float(shape.refinement.factors[std::size_t(axis)]));
        mTolerance = radius / 4;
    }

    /// Add the visible parts of a tail in the domain, ordered from the tail's end to the head.
    void add(const Streak& streak, Block& block) const
    {
        const std::size_t before = block.parts.size();
        for (Samples& part : inBox(samples(streak))) {
            for (const Samples& inside : inDomain(std::move(part))) {
                const std::size_t begin = block.samples.size();
                addThinned(inside, block.samples);
                block.parts.push_back({true, streak.name, begin, block.samples.size(), &block.samples, &streak});
            }
        }
        if (block.parts.size() > before) block.parts.back().isRest = false;
    }

  private:
    [[nodiscard]] Samples samples(const Streak& streak) const
    {
        const double oldest = streak.tailEnd(mTime, mTail);
        const double bright = streak.brightness(mTime);
        // The value rises linearly from the tail's end to the head.
        const double first =
            bright > kLeastStreakValue ? oldest + (mTime - oldest) * kLeastStreakValue / bright : mTime;
        Samples all;
        for (std::size_t i = 1; i < streak.path.size(); ++i) {
            const StreakNode &a = streak.path[i - 1], &b = streak.path[i];
            const double from = std::max(a.time, first), to = std::min(b.time, mTime);
            if (!(from < to)) continue;
            if (all.empty()) all.push_back({placeAt(a, b, from), from});
            const int count = pieces(a, b, from, to);
            for (int k = 1; k <= count; ++k) {
                const double time = k == count ? to : from + (to - from) * k / count;
                all.push_back({placeAt(a, b, time), time});
            }
        }
        return all;
    }

    /// Cut samples at the seams of a periodic box, and move each part into the box.
    [[nodiscard]] std::vector<Samples> inBox(Samples all) const
    {
        const Period& period = mDomain.period();
        std::vector<Samples> parts;
        if (period.isNone() || all.size() < 2) {
            parts.push_back(std::move(all));
            return parts;
        }
        openvdb::Vec3f last(0); // way of the last part into the box
        for (std::size_t i = 1; i < all.size(); ++i) {
            const std::vector<double> shares = seamsBetween(all[i - 1].position, all[i].position);
            for (std::size_t k = 1; k < shares.size(); ++k) {
                if (shares[k] == shares[k - 1]) continue; // seams of two axes meet
                const Sample from = sampleAt(all[i - 1], all[i], shares[k - 1]),
                             to = sampleAt(all[i - 1], all[i], shares[k]);
                const openvdb::Vec3f way = wayIntoBox((from.position + to.position) * 0.5f);
                if (parts.empty() || way != last) parts.push_back({{from.position + way, from.time}});
                parts.back().push_back({to.position + way, to.time});
                last = way;
            }
        }
        return parts;
    }

    /// Where the straight line between two positions crosses seams: shares of its length, with 0 and 1, ascending.
    [[nodiscard]] std::vector<double> seamsBetween(const openvdb::Vec3f& a, const openvdb::Vec3f& b) const
    {
        constexpr double kMost = 64; // crossings of an axis, by lines that are far too long
        const Period& period = mDomain.period();
        std::vector<double> shares{0, 1};
        for (int axis = 0; axis < 3; ++axis) {
            const double size = period.size[axis], begin = period.first[axis] - 0.5;
            if (size == 0) continue;
            const double from = (double(a[axis]) - begin) / size, to = (double(b[axis]) - begin) / size;
            const double low = std::min(from, to), high = std::min(std::max(from, to), low + kMost);
            const double seam = std::floor(low) + 1;
            for (int i = 0; seam + i < high; ++i)
                shares.push_back((seam + i - from) / (to - from));
        }
        std::sort(shares.begin(), shares.end());
        return shares;
    }

    [[nodiscard]] static Sample sampleAt(const Sample& a, const Sample& b, double share)
    {
        if (share == 0 || share == 1) return share == 0 ? a : b;
        return {a.position + (b.position - a.position) * float(share), a.time + (b.time - a.time) * share};
    }

    /// The whole periods from a position to its image in the box.
    [[nodiscard]] openvdb::Vec3f wayIntoBox(const openvdb::Vec3f& position) const
    {
        const Period& period = mDomain.period();
        openvdb::Vec3f way(0);
        for (int axis = 0; axis < 3; ++axis) {
            const auto size = float(period.size[axis]), begin = float(period.first[axis]) - 0.5f;
            if (size > 0) way[axis] = -std::floor((position[axis] - begin) / size) * size;
        }
        return way;
    }

    /// Cut samples at the domain's rim.
    [[nodiscard]] std::vector<Samples> inDomain(Samples all) const
    {
        std::vector<Samples> parts;
        if (std::ranges::all_of(all, [&](const Sample& sample) { return isInDomain(sample.position); })) {
            if (all.size() > 1) parts.push_back(std::move(all));
            return parts;
        }
        bool wasInside = false;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const bool isInside = isInDomain(all[i].position);
            if (isInside && !wasInside) parts.emplace_back();
            if (i > 0 && isInside != wasInside) parts.back().push_back(rimBetween(all[i - 1], all[i], wasInside));
            if (isInside) parts.back().push_back(all[i]);
            wasInside = isInside;
        }
        std::erase_if(parts, [](const Samples& part) { return part.size() < 2; });
        return parts;
    }

    [[nodiscard]] bool isInDomain(const openvdb::Vec3f& position) const
    {
        const Float4 at{position[0], position[1], position[2], 0};
        if (mDomain.isWhole()) return covers(mDomain, at);
        const Int4 voxel = voxelOf(at); // in any rank's leaf
        return mDomain.topology().isValueOn(mDomain.period().wrapped({voxel[0], voxel[1], voxel[2]}));
    }

    /// The last point inside on the straight line between two samples, one of them outside.
    [[nodiscard]] Sample rimBetween(const Sample& a, const Sample& b, bool isFirstInside) const
    {
        constexpr int kHalvings = 12;
        Sample inside = isFirstInside ? a : b, outside = isFirstInside ? b : a;
        for (int i = 0; i < kHalvings; ++i) {
            const Sample middle{(inside.position + outside.position) * 0.5f, (inside.time + outside.time) / 2};
            (isInDomain(middle.position) ? inside : outside) = middle;
        }
        return inside;
    }

    [[nodiscard]] static openvdb::Vec3f placeAt(const StreakNode& a, const StreakNode& b, double time)
    {
        const auto at = positionBetween(a, b, float((time - a.time) / (b.time - a.time)));
        return {at[0], at[1], at[2]};
    }

    /// Number of straight pieces for a curve between two nodes: a parabola deviates by h²/8 of its second derivative.
    [[nodiscard]] int pieces(const StreakNode& a, const StreakNode& b, double from, double to) const
    {
        constexpr double kMost = 4096;
        const double whole = b.time - a.time, part = (to - from) / whole;
        double atStart = 0, atEnd = 0; // second derivative by share of time, squared; linear in between
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double chord = double(b.position[axis]) - double(a.position[axis]);
            const double m0 = double(a.slope[axis]) * whole, m1 = double(b.slope[axis]) * whole;
            atStart += std::pow(6 * chord - 4 * m0 - 2 * m1, 2);
            atEnd += std::pow(-6 * chord + 2 * m0 + 4 * m1, 2);
        }
        const double second = std::sqrt(std::max(atStart, atEnd));
        return int(std::ceil(std::clamp(part * std::sqrt(second / (8 * double(mTolerance) / 2)), 1.0, kMost)));
    }

    /// Add few samples within the tolerance at equal times: keep the farthest one between two kept ones until none is
    /// too far (Douglas and Peucker 1973).
    void addThinned(const Samples& all, Samples& samples) const
    {
        std::vector<bool> isKept(all.size(), false);
        isKept.front() = isKept.back() = true;
        std::vector<std::array<std::size_t, 2>> spans{{0, all.size() - 1}};
        while (!spans.empty()) {
            const auto [first, last] = spans.back();
            spans.pop_back();
            const Sample &a = all[first], &b = all[last];
            double farthest = double(mTolerance) / 2;
            std::size_t at = 0;
            for (std::size_t i = first + 1; i < last; ++i) {
                const auto share = float((all[i].time - a.time) / (b.time - a.time));
                const double distance =
                    double((all[i].position - (a.position + (b.position - a.position) * share)).length());
                if (distance <= farthest) continue;
                farthest = distance;
                at = i;
            }
            if (at == 0) continue;
            isKept[at] = true;
            spans.push_back({first, at});
            spans.push_back({at, last});
        }
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (isKept[i]) samples.push_back(all[i]);
        }
    }

    const Domain& mDomain;
    double mTime, mTail;
    float mTolerance = 0; // [voxels of the velocity]
};

/// Maps 64-bit names to 32-bit numbers. If one is taken, the next free one is used.
class Numbers {
  public:
    /// @param most names
    explicit Numbers(std::size_t most) : mTaken(std::bit_ceil(2 * most + 1)) {}

    [[nodiscard]] std::int32_t of(std::uint64_t name)
    {
        auto number = std::uint32_t(name);
        while (!take(number))
            ++number;
        return std::int32_t(number);
    }

  private:
    /// @return whether it was free
    bool take(std::uint32_t number)
    {
        const std::size_t last = mTaken.size() - 1;
        std::size_t at = number & last;
        while (mTaken[at] != 0 && mTaken[at] != std::uint64_t(number) + 1)
            at = (at + 1) & last;
        return std::exchange(mTaken[at], std::uint64_t(number) + 1) == 0;
    }

    std::vector<std::uint64_t> mTaken; // a hash table of numbers plus 1, and 0 where it is free
};

/// The mean radius of a streak's head in world space.
float worldRadius(const StreakShape& shape, const openvdb::math::Transform& transform)
{
    double product = 1;
    const openvdb::Vec3d voxel = transform.voxelSize();
    for (int axis = 0; axis < 3; ++axis)
        product *= double(shape.radius(axis)) / shape.refinement.factors[std::size_t(axis)] * voxel[axis];
    return float(std::cbrt(product));
}

} // namespace

Lines streakLines(const std::vector<Streak>& streaks, const StreakShape& shape, const Domain& domain, double time,
                  const openvdb::math::Transform& transform)
{
    const TailSampler sampler(shape, domain, time);
    constexpr std::size_t kTogether = 1024; // streaks of a block
    std::vector<Block> blocks((streaks.size() + kTogether - 1) / kTogether);
    tbb::parallel_for(std::size_t(0), blocks.size(), [&](std::size_t block) {
        const std::size_t first = block * kTogether;
        for (std::size_t i = first; i < std::min(first + kTogether, streaks.size()); ++i)
            sampler.add(streaks[i], blocks[block]);
    });
    std::vector<Part> parts;
    for (const Block& block : blocks)
        parts.insert(parts.end(), block.parts.begin(), block.parts.end());
    tbb::parallel_sort(parts);
    Lines lines;
    Numbers numbers(parts.size());
    std::uint32_t end = 0;
    for (const Part& part : parts) {
        const std::uint32_t begin = std::exchange(end, end + std::uint32_t(part.end - part.begin));
        lines.lines.push_back({numbers.of(part.name), begin, end, part.streak->source});
    }
    lines.positions.resize(end);
    lines.radii.resize(end);
    lines.opacities.resize(end);
    lines.ages.resize(end);
    const float radius = worldRadius(shape, transform);
    tbb::parallel_for(std::size_t(0), parts.size(), [&](std::size_t i) {
        const Part& part = parts[i];
        const double oldest = part.streak->tailEnd(time, double(shape.tail));
        const auto bright = float(part.streak->brightness(time));
        std::size_t to = lines.lines[i].begin;
        for (const Sample& sample : std::span(*part.samples).subspan(part.begin, part.end - part.begin)) {
            const float share = std::clamp(float((sample.time - oldest) / (time - oldest)), 0.0f, 1.0f);
            lines.positions[to] = sample.position;
            lines.opacities[to] = bright * share;
            lines.radii[to] = radius * (kTailWidth + (1 - kTailWidth) * share);
            lines.ages[to++] = float(time - sample.time);
        }
    });
    return lines;
}

} // namespace vdblic
