#pragma once

#include "vdblic/flow/velocity_frame.h"
#include "vdblic/methods/texture_params.h"

#include <openvdb/openvdb.h>

#include <optional>
#include <vector>

namespace vdblic::test {

/// Trilinear interpolation between eight corners. @param cornerOf called with 0 or 1 for each axis, gives a number
template<typename CornerOf>
float trilinear(const openvdb::Vec3f& fraction, const CornerOf& cornerOf)
{
    const float x = fraction[0], y = fraction[1], z = fraction[2];
    const auto edge = [&](int i, int j, float weight) {
        return cornerOf(i, j, 0) * (weight * (1 - z)) + cornerOf(i, j, 1) * (weight * z);
    };
    return (edge(0, 0, (1 - x) * (1 - y)) + edge(0, 1, (1 - x) * y)) + (edge(1, 0, x * (1 - y)) + edge(1, 1, x * y));
}

/// Where a position is looked up that lies between voxels, of which blocks of 8³ are there: it is its own place if the
/// lowest corner of its cell lies in such a block. Else the values of a block's first voxels go on for half a voxel:
/// the place is at their centres, moved along as few axes as necessary, the first ones first. Nothing farther outside.
std::optional<openvdb::Vec3f> placeInBlocks(const openvdb::MaskTree& blocks, const openvdb::Vec3f& position);

/// The velocity over a step in texture voxels per step, looked up in the frames' grids one voxel at a time.
///
/// It is trilinear between those voxels around a position that have a value, and linear in time between the two frames,
/// values and weights each for themselves: a voxel without a value in one frame keeps that of the other.
class LiteralField {
  public:
    /// Both must outlive this.
    LiteralField(const VelocityFrame& start, const VelocityFrame& end)
        : mStart(start), mEnd(end), mAtStart(start.values->getConstAccessor()), mAtEnd(end.values->getConstAccessor())
    {
    }

    /// @param position index space of the texture  @param time 0 to 1  @return nothing without a value
    [[nodiscard]] std::optional<openvdb::Vec3f> at(const openvdb::Vec3f& position, float time) const;

    [[nodiscard]] const VelocityFrame& start() const { return mStart; }
    [[nodiscard]] const VelocityFrame& end() const { return mEnd; }
    /// Whether the texture has the voxel in which a position lies.
    [[nodiscard]] bool covers(const openvdb::Vec3f& position) const;

  private:
    const VelocityFrame &mStart, &mEnd;
    openvdb::Vec3SGrid::ConstAccessor mAtStart, mAtEnd;
};

/// The voxel in which a position lies; centres are at integers.
openvdb::Coord voxelAround(const openvdb::Vec3f& position);

/// A voxel that a pathline passes.
struct LiteralSample {
    openvdb::Coord voxel;
    bool early; ///< within the release window
};

/// A particle over one step.
struct LiteralTrace {
    openvdb::Vec3f position, slope;     ///< at the end
    std::vector<LiteralSample> samples; ///< inside the domain
    bool ended = false;                 ///< left the domain
};

/// Advance a particle by one step: RK4 with an embedded error estimate, Hermite curves between, samples at even arc
/// length (Liu & Moorhead 2004, section 3; docs/algorithm.md; Hairer, Nørsett & Wanner, Solving ODEs I, II.4 and II.6).
/// One particle, one component and one voxel at a time; each sum in the engine's order, so that results can be equal
/// to the bit.
LiteralTrace literalTrace(const LiteralField& field, const TextureParams& params, openvdb::Vec3f position,
                          openvdb::Vec3f slope);

} // namespace vdblic::test
