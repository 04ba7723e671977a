#include "vdblic/methods/streaks/streak_pieces.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdblic {
namespace {

constexpr float kPieceLength = 4; // texture voxels

/// Cuts streaks into pieces.
class PieceCutter {
  public:
    PieceCutter(const StreakShape& shape, double time) : mShape(shape), mTime(time) {}

    void cut(const Streak& streak, std::uint32_t number, std::vector<StreakPiece>& pieces) const
    {
        const auto bright = float(streak.brightness(mTime));
        const double oldest = streak.tailEnd(mTime, double(mShape.tail));
        for (std::size_t i = 1; i < streak.path.size(); ++i) {
            const StreakNode &a = streak.path[i - 1], &b = streak.path[i];
            const double first = std::max(a.time, oldest), last = std::min(b.time, mTime);
            if (!(first < last) || bright * shareAt(last, oldest) < kLeastStreakValue) continue;
            cutCurve(a, b, first, last, oldest, bright, number, pieces);
        }
    }

  private:
    /// The position of a time between the tail's end, 0, and the head, 1.
    [[nodiscard]] float shareAt(double time, double oldest) const
    {
        return std::clamp(float((time - oldest) / (mTime - oldest)), 0.0f, 1.0f);
    }

    void cutCurve(const StreakNode& a, const StreakNode& b, double first, double last, double oldest, float bright,
                  std::uint32_t number, std::vector<StreakPiece>& pieces) const
    {
        const auto at = [&](double time) {
            return inTexture(positionBetween(a, b, float((time - a.time) / (b.time - a.time))));
        };
        std::array<float, 3> from = at(first);
        const std::array<float, 3> to = at(last);
        float longest = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float slope = std::max(std::abs(a.slope[axis]), std::abs(b.slope[axis])) * float(last - first) *
                                float(mShape.refinement.factors[axis]);
            longest = std::max({longest, slope, std::abs(to[axis] - from[axis])});
        }
        constexpr float kMost = 4096;
        const int count = int(std::ceil(std::clamp(longest / kPieceLength, 1.0f, kMost)));
        for (int i = 1; i <= count; ++i) {
            const double begin = first + (last - first) * (i - 1) / count, end = first + (last - first) * i / count;
            const std::array<float, 3> next = i == count ? to : at(end);
            const float s0 = shareAt(begin, oldest), s1 = shareAt(end, oldest);
            pieces.push_back({from, next, bright * s0, bright * s1, kTailWidth + (1 - kTailWidth) * s0,
                              kTailWidth + (1 - kTailWidth) * s1, number, i == count && last == mTime});
            from = next;
        }
    }

    [[nodiscard]] std::array<float, 3> inTexture(std::array<float, 3> position) const
    {
        for (int axis = 0; axis < 3; ++axis) {
            float& coordinate = position[std::size_t(axis)];
            coordinate =
                (coordinate - mShape.refinement.shift(axis)) * float(mShape.refinement.factors[std::size_t(axis)]);
        }
        return position;
    }

    const StreakShape& mShape;
    double mTime;
};

} // namespace

std::vector<StreakPiece> piecesOf(const std::vector<Streak>& streaks, const StreakShape& shape, double time)
{
    constexpr std::size_t kChunk = 256; // streaks
    const PieceCutter cutter(shape, time);
    std::vector<std::vector<StreakPiece>> chunks((streaks.size() + kChunk - 1) / kChunk);
    tbb::parallel_for(std::size_t(0), chunks.size(), [&](std::size_t chunk) {
        const std::size_t end = std::min((chunk + 1) * kChunk, streaks.size());
        for (std::size_t i = chunk * kChunk; i < end; ++i)
            cutter.cut(streaks[i], std::uint32_t(i), chunks[chunk]);
    });
    std::vector<StreakPiece> pieces;
    std::size_t count = 0;
    for (const std::vector<StreakPiece>& chunk : chunks)
        count += chunk.size();
    pieces.reserve(count);
    for (const std::vector<StreakPiece>& chunk : chunks)
        pieces.insert(pieces.end(), chunk.begin(), chunk.end());
    return pieces;
}

} // namespace vdblic
