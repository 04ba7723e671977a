#include "vdblic/cast/blue_noise.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {
namespace {

constexpr int kTileDim = BlueNoise::kDim, kTilePixels = BlueNoise::kCount;
constexpr int kPointReach = 7;      // of a point's weight [pixels]
constexpr double kPointWidth = 1.5; // deviation of the weight [pixels]
constexpr int kFirstPoints = kTilePixels / 10;

/// Points of the tile, and at every pixel the sum of the points' weights. Weights are integers, so that sums are exact.
class PointSet {
  public:
    PointSet() : mSums(std::size_t(kTilePixels)), mSet(std::size_t(kTilePixels))
    {
        for (int y = -kPointReach; y <= kPointReach; ++y) {
            for (int x = -kPointReach; x <= kPointReach; ++x)
                mWeights.push_back(
                    int(std::lround(1e6 * std::exp(-(x * x + y * y) / (2 * kPointWidth * kPointWidth)))));
        }
    }

    [[nodiscard]] bool has(int pixel) const { return mSet[std::size_t(pixel)] != 0; }
    void add(int pixel) { change(pixel, true); }
    void remove(int pixel) { change(pixel, false); }
    /// The point with the nearest neighbours.
    [[nodiscard]] int tightestCluster() const
    {
        int best = -1;
        for (int pixel = 0; pixel < kTilePixels; ++pixel) {
            if (has(pixel) && (best < 0 || sum(pixel) > sum(best))) best = pixel;
        }
        return best;
    }
    /// The free pixel farthest from all points.
    [[nodiscard]] int largestVoid() const
    {
        int best = -1;
        for (int pixel = 0; pixel < kTilePixels; ++pixel) {
            if (!has(pixel) && (best < 0 || sum(pixel) < sum(best))) best = pixel;
        }
        return best;
    }

  private:
    [[nodiscard]] int sum(int pixel) const { return mSums[std::size_t(pixel)]; }
    void change(int pixel, bool in)
    {
        mSet[std::size_t(pixel)] = in;
        std::size_t weight = 0;
        for (int y = -kPointReach; y <= kPointReach; ++y) {
            for (int x = -kPointReach; x <= kPointReach; ++x, ++weight) {
                const int row = (pixel / kTileDim + y + kTileDim) % kTileDim,
                          column = (pixel % kTileDim + x + kTileDim) % kTileDim;
                mSums[std::size_t(row * kTileDim + column)] += in ? mWeights[weight] : -mWeights[weight];
            }
        }
    }

    std::vector<int> mWeights, mSums;
    std::vector<char> mSet;
};

BlueNoise makeBlueNoise()
{
    // Scattered points are moved from clusters to voids until they are spread evenly.
    PointSet points;
    unsigned state = 1;
    for (int placed = 0; placed < kFirstPoints;) {
        state = state * 1664525u + 1013904223u; // Numerical Recipes' generator
        const int pixel = int((state >> 8) % unsigned(kTilePixels));
        if (points.has(pixel)) continue;
        points.add(pixel);
        ++placed;
    }
    while (true) {
        const int from = points.tightestCluster();
        points.remove(from);
        const int to = points.largestVoid();
        points.add(to);
        if (from == to) break;
    }
    // Their ranks fall as clusters are thinned out; the ranks of all others rise as voids are filled.
    BlueNoise noise{};
    PointSet thinned = points;
    for (int rank = kFirstPoints - 1; rank >= 0; --rank) {
        const int pixel = thinned.tightestCluster();
        thinned.remove(pixel);
        noise.ranks[std::size_t(pixel)] = std::uint16_t(rank);
    }
    for (int rank = kFirstPoints; rank < kTilePixels; ++rank) {
        const int pixel = points.largestVoid();
        points.add(pixel);
        noise.ranks[std::size_t(pixel)] = std::uint16_t(rank);
    }
    return noise;
}

} // namespace

const BlueNoise& blueNoise()
{
    static const BlueNoise noise = makeBlueNoise();
    return noise;
}

} // namespace vdblic
