#include "vdblic/methods/ibfv/periodic_noise.h"

#include "vdblic/noise/noise.h"

#include <array>
#include <cstddef>

namespace vdblic {

float PeriodicNoise::ofPoint(int x, int y, int z) const
{
    const std::uint32_t phase =
        std::uint32_t(mNoise->at(mPeriod.wrapped({kSpacing * x, kSpacing * y, kSpacing * z}))) + mTurn;
    return (phase & std::uint32_t(kNoiseMax)) <= std::uint32_t(kNoiseMax / 2) ? 1.0f : 0.0f;
}

void PeriodicNoise::fill(const openvdb::Coord& origin, float* values) const
{
    constexpr int kPoints = LeafVoxel::kDim / kSpacing + 1;
    static_assert(kSpacing == 2 && kSpacing * (kPoints - 1) + 1 == kBrick);
    std::array<std::array<std::array<float, kBrick>, kBrick>, kPoints> planes{}; // for each x of the points
    for (int x = 0; x < kPoints; ++x) {
        auto& plane = planes[std::size_t(x)];
        for (int y = 0; y < kPoints; ++y) {
            auto& line = plane[std::size_t(kSpacing) * std::size_t(y)];
            for (int z = 0; z < kPoints; ++z) {
                line[std::size_t(kSpacing) * std::size_t(z)] =
                    ofPoint(origin[0] / kSpacing + x, origin[1] / kSpacing + y,
                            origin[2] / kSpacing + z); // leaves begin at points
            }
            for (std::size_t z = 1; z < kBrick; z += kSpacing)
                line[z] = 0.5f * (line[z - 1] + line[z + 1]);
        }
        for (std::size_t y = 1; y < kBrick; y += kSpacing) {
            for (std::size_t z = 0; z < kBrick; ++z)
                plane[y][z] = 0.5f * (plane[y - 1][z] + plane[y + 1][z]);
        }
    }
    for (std::size_t x = 0; x < kBrick; ++x) {
        const auto &below = planes[x / kSpacing], &above = planes[(x + 1) / kSpacing];
        for (std::size_t y = 0; y < kBrick; ++y) {
            for (std::size_t z = 0; z < kBrick; ++z)
                *values++ = 0.5f * (below[y][z] + above[y][z]);
        }
    }
}

} // namespace vdblic
