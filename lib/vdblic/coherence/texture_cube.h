#pragma once

#include <openvdb/math/Vec3.h>

#include <array>
#include <cstddef>
#include <optional>

namespace vdblic {

/// The 7³ voxels of a texture around one. The inner 5³ voxels have all their neighbours in it.
class TextureCube {
  public:
    static constexpr int kRadius = 3, kDim = 2 * kRadius + 1;
    static constexpr int kInner = (kDim - 2) * (kDim - 2) * (kDim - 2);

    using Row = std::array<float, kDim>;
    /// The voxels along z at x and y, 0 to kDim − 1.
    [[nodiscard]] Row& row(int x, int y) { return mRows[unsigned(x * kDim + y)]; }
    [[nodiscard]] float at(int x, int y, int z) const { return mRows[unsigned(x * kDim + y)][unsigned(z)]; }
    [[nodiscard]] float centre() const { return at(kRadius, kRadius, kRadius); }

    /// Visit the inner voxels: visit(x, y, z).
    template<typename Visit>
    static void forEachInner(const Visit& visit)
    {
        for (int x = 1; x < kDim - 1; ++x) {
            for (int y = 1; y < kDim - 1; ++y) {
                for (int z = 1; z < kDim - 1; ++z)
                    visit(x, y, z);
            }
        }
    }

    /// Number of inner voxels that are beyond the range of their 26 neighbours by more than a distance.
    [[nodiscard]] int countIsolated(float distance) const;

    struct Lines {
        double strength = 0;                           ///< (w2 − w1) / (w2 + w1): 1 for straight lines, 0 for grains
        std::optional<openvdb::math::Vec3d> direction; ///< unit length; none for layers or a constant
    };
    /// The lines that the structure tensor shows, whose eigenvalues are w1 ≤ w2 ≤ w3. The tensor is the mean over the
    /// inner voxels of the products of the gradient's components, by central differences.
    [[nodiscard]] Lines lines() const;

  private:
    std::array<Row, std::size_t(kDim) * kDim> mRows;
};

} // namespace vdblic
