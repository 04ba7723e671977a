#include "vdblic/lines/lines_between.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace vdblic {
namespace {

/// The other number if one is NaN.
float mixed(float a, float b, double share)
{
    if (std::isnan(a)) return b;
    return std::isnan(b) ? a : a + (b - a) * float(share);
}

/// A line of one of the frames, by time since the earlier frame.
class Track {
  public:
    /// @param line null: none
    Track(const Lines& lines, const Lines::Line* line, double frame)
        : mLines(lines), mBegin(line ? line->begin : 0), mEnd(line ? line->end : 0), mFrame(frame)
    {
    }

    [[nodiscard]] bool empty() const { return mBegin == mEnd; }
    [[nodiscard]] double first() const { return timeOf(mBegin); }
    [[nodiscard]] double last() const { return timeOf(mEnd - 1); }
    [[nodiscard]] double oldest() const { return double(mLines.ages[mBegin]); }
    [[nodiscard]] bool covers(double time) const { return !empty() && time >= first() && time <= last(); }

    /// Append the times of its points between two times.
    void addTimes(double from, double to, std::vector<double>& times) const
    {
        for (std::uint32_t i = mBegin; i < mEnd; ++i) {
            if (timeOf(i) > from && timeOf(i) < to) times.push_back(timeOf(i));
        }
    }

    [[nodiscard]] openvdb::Vec3f position(double time) const
    {
        const auto [first, second, share] = around(mFrame - time);
        const openvdb::Vec3f &a = mLines.positions[first], &b = mLines.positions[second];
        return a + (b - a) * float(share);
    }
    /// Beyond the line that of its end; NaN where it has none.
    [[nodiscard]] float scalar(const std::string& name, double time) const
    {
        const auto isIt = [&](const Lines::Scalar& scalar) { return scalar.name == name; };
        const auto found = std::find_if(mLines.scalars.begin(), mLines.scalars.end(), isIt);
        return found != mLines.scalars.end() && !empty() ? valueAt(found->values, mFrame - time) : kNone;
    }
    /// By age in the line's own frame; NaN without a line.
    [[nodiscard]] float radius(double age) const { return empty() ? kNone : valueAt(mLines.radii, age); }
    /// By age in the line's own frame, 0 behind the tail.
    [[nodiscard]] float opacity(double age) const
    {
        return empty() || age > oldest() ? 0 : valueAt(mLines.opacities, age);
    }

  private:
    static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

    struct Place {
        std::uint32_t first, second;
        double share; // between the two
    };
    [[nodiscard]] float valueAt(const std::vector<float>& values, double age) const
    {
        const auto [first, second, share] = around(age);
        return mixed(values[first], values[second], share);
    }
    [[nodiscard]] double timeOf(std::uint32_t point) const { return mFrame - double(mLines.ages[point]); }
    /// Between the points on both sides of an age; at an end of the line beyond it.
    [[nodiscard]] Place around(double age) const
    {
        const auto begin = mLines.ages.begin() + mBegin, end = mLines.ages.begin() + mEnd;
        const auto younger = std::partition_point(begin, end, [&](float of) { return double(of) > age; });
        if (younger == begin) return {mBegin, mBegin, 0};
        if (younger == end) return {mEnd - 1, mEnd - 1, 0};
        const auto second = std::uint32_t(younger - mLines.ages.begin());
        const double older = double(mLines.ages[second - 1]), part = (older - age) / (older - double(*younger));
        return {second - 1, second, std::clamp(part, 0.0, 1.0)};
    }

    const Lines& mLines;
    std::uint32_t mBegin, mEnd;
    double mFrame; // time of the line's frame
};

/// A line of both frames, or of one.
struct Pair {
    const Lines::Line *before, *after;
    const Lines::Line& newest;
};

/// Makes the lines one by one. Times count from the earlier frame.
class Joiner {
  public:
    Joiner(const Lines& before, const Lines& after, double share, double interval)
        : mBefore(before), mAfter(after), mShare(share), mInterval(interval), mTime(share * interval)
    {
        for (const Lines::Scalar& scalar : before.scalars)
            mNames.push_back(scalar.name);
        for (const Lines::Scalar& scalar : after.scalars) {
            if (std::find(mNames.begin(), mNames.end(), scalar.name) == mNames.end()) mNames.push_back(scalar.name);
        }
    }

    [[nodiscard]] std::vector<Pair> pairs() const
    {
        constexpr double kSeam = 0.02; // ages are stored more exactly
        std::vector<Pair> pairs;
        auto later = mAfter.lines.begin();
        for (const Lines::Line& line : mBefore.lines) {
            for (; later != mAfter.lines.end() && later->id < line.id; ++later)
                pairs.push_back({nullptr, &*later, *later});
            const bool goesOn = later != mAfter.lines.end() && later->id == line.id &&
                                Track(mAfter, &*later, mInterval).first() <= Track(mBefore, &line, 0).last() + kSeam;
            const Lines::Line* const after = goesOn ? &*later++ : nullptr;
            pairs.push_back({&line, after, after ? *after : line});
        }
        for (; later != mAfter.lines.end(); ++later)
            pairs.push_back({nullptr, &*later, *later});
        return pairs;
    }

    [[nodiscard]] Lines noLines() const
    {
        Lines lines;
        for (const std::string& name : mNames)
            lines.scalars.push_back({name, {}});
        return lines;
    }

    /// A line alone; empty if its particle is still to come.
    [[nodiscard]] Lines lineOf(const Pair& pair) const
    {
        const Track before(mBefore, pair.before, 0), after(mAfter, pair.after, mInterval);
        const double longest = std::max(before.empty() ? 0 : before.oldest(), after.empty() ? 0 : after.oldest());
        const double begin = std::max(before.empty() ? after.first() : before.first(), mTime - longest);
        const double end = after.empty() ? before.last() : std::min(after.last(), mTime);
        Lines line = noLines();
        if (!(begin < end)) return line;
        std::vector<double> times{begin};
        before.addTimes(begin, after.empty() ? end : std::min(after.first(), end), times);
        after.addTimes(begin, end, times);
        times.push_back(end);
        for (const double time : times)
            addPoint(before, after, time, line);
        line.lines.push_back({pair.newest.id, 0, std::uint32_t(times.size()), pair.newest.source});
        return line;
    }

  private:
    void addPoint(const Track& before, const Track& after, double time, Lines& line) const
    {
        const double age = mTime - time;
        const bool isLater = after.covers(time) || before.empty();
        line.positions.push_back(isLater ? after.position(time) : before.position(time));
        line.radii.push_back(mixed(before.radius(age), after.radius(age), mShare));
        line.opacities.push_back(mixed(before.opacity(age), after.opacity(age), mShare));
        line.ages.push_back(float(age));
        for (Lines::Scalar& scalar : line.scalars)
            scalar.values.push_back(mixed(before.scalar(scalar.name, time), after.scalar(scalar.name, time), mShare));
    }

    const Lines &mBefore, &mAfter;
    double mShare, mInterval, mTime;
    std::vector<std::string> mNames; // of all scalars
};

} // namespace

Lines linesBetween(const Lines& before, const Lines& after, double share, double interval)
{
    const Joiner joiner(before, after, share, interval);
    const std::vector<Pair> pairs = joiner.pairs();
    std::vector<Lines> made(pairs.size());
    tbb::parallel_for(std::size_t(0), pairs.size(), [&](std::size_t i) { made[i] = joiner.lineOf(pairs[i]); });
    Lines all = joiner.noLines();
    const auto append = [](auto& values, const auto& more) { values.insert(values.end(), more.begin(), more.end()); };
    for (const Lines& one : made) {
        const auto begin = std::uint32_t(all.pointCount());
        for (const Lines::Line& line : one.lines)
            all.lines.push_back({line.id, begin + line.begin, begin + line.end, line.source});
        append(all.positions, one.positions);
        append(all.radii, one.radii);
        append(all.opacities, one.opacities);
        append(all.ages, one.ages);
        for (std::size_t i = 0; i < all.scalars.size(); ++i)
            append(all.scalars[i].values, one.scalars[i].values);
    }
    return all;
}

} // namespace vdblic
