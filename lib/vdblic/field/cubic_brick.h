#pragma once

#include "vdblic/field/bricks.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocities.h"

#include <openvdb/openvdb.h>

#include <array>
#include <vector>

namespace vdblic {

/// Velocities at the voxels of a texture leaf's brick by cubic convolution, smooth across the faces of the velocity's
/// cells (Keys, "Cubic convolution interpolation for digital image processing", 1981, with a = −½).
///
/// A voxel of the velocity without a value counts as the mean of its neighbours, those two voxels away included. The
/// coverage is interpolated linearly. One object serves one thread.
class CubicBrick {
  public:
    /// @param origin of the texture's leaf
    CubicBrick(const Refinement& refinement, const openvdb::Coord& origin);

    /// Fill four numbers of each record: the velocity, premultiplied by the coverage, and the coverage.
    /// @param lane of the first number, 0 or 4
    void fill(const Velocities<Space::kTexture, Per::kStep>& velocities, Record* records, int lane);

  private:
    static constexpr int kTaps = 4;

    /// The four velocity voxels around a texture voxel along an axis: the first one's index in the block, and weights.
    /// Numbers 0 to 2 of a weight are for the velocity, number 3 for the coverage.
    struct Taps {
        int first = 0;
        std::array<Float4, kTaps> weights{};
    };

    [[nodiscard]] int index(int x, int y, int z) const { return (x * mSize[1] + y) * mSize[2] + z; }
    void gather(const Velocities<Space::kTexture, Per::kStep>& velocities);
    void extend();

    openvdb::Coord mFirst; // velocity voxel at the block's first corner
    std::array<int, 3> mSize{};
    std::array<std::array<Taps, Bricks::kDim>, 3> mTaps;
    std::vector<Float4> mBlock, mLines, mPlanes; // of the velocity; interpolated along z; along y too
};

} // namespace vdblic
