#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/field/moved_velocity.h"

#include <openvdb/openvdb.h>

#include <array>
#include <optional>

namespace vdblic {

/// An observer of a flow: at rest in the world, or with a constant velocity, a constant rate of rotation, or both. At
/// the time of the sequence's first frame on disk the observer's space is the world.
struct ReferenceFrameParams {
    std::optional<std::array<double, 3>> velocity{}; ///< [world units per second]
    bool followsMean = false;                        ///< take the mean velocity of that frame in place of `velocity`
    double rotation = 0;                             ///< right-handed about the axis [turns per minute]
    std::optional<std::array<double, 3>> axis{};     ///< of any length; nothing: z
    std::optional<std::array<double, 3>> point{};    ///< on the axis, moves with `velocity`; nothing: the origin
    bool stay = false; ///< whether textures stay in the observer's space, which the world moves past

    [[nodiscard]] bool isAtRest() const { return !velocity && !followsMean && rotation == 0; }
    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(ReferenceFrameParams& params);

/// Velocities of one space from those of another that moves: ofVelocity · velocity + ofPlace · place + constant.
struct VelocityMap {
    openvdb::Mat3d ofVelocity = openvdb::Mat3d::identity(), ofPlace = openvdb::Mat3d::zero();
    openvdb::Vec3d constant{0, 0, 0};

    [[nodiscard]] openvdb::Vec3d at(const openvdb::Vec3d& velocity, const openvdb::Vec3d& place) const
    {
        return ofVelocity * velocity + ofPlace * place + constant;
    }
};

/// The space of a moving observer. With U the velocity, ω the rotation and R the turn since the start, a point x' of
/// the observer is at x = p + R (x' − p) + U t, and sees the velocity Rᵀ (u − U) − ω × (x' − p).
///
/// A way of a whole number of voxels, to 1e-4, is exact: voxels fall on voxels. Immutable; any number of threads may
/// use it.
class ReferenceFrame {
  public:
    /// @param params with a velocity if any: `followsMean` is ignored  @param voxels transform of the velocity, linear
    ReferenceFrame(const ReferenceFrameParams& params, const openvdb::math::Transform& voxels);

    [[nodiscard]] const ReferenceFrameParams& params() const { return mParams; }

    // @param seconds since the start

    /// The transform in the world of a grid of the observer's space, and the reverse.
    [[nodiscard]] openvdb::math::Transform::Ptr toWorld(const openvdb::math::Transform& seen, double seconds) const;
    [[nodiscard]] openvdb::math::Transform::Ptr fromWorld(const openvdb::math::Transform& world, double seconds) const;
    /// The voxels of the velocity in the world, from the same ones in the observer's space.
    [[nodiscard]] IndexMap toWorldVoxels(double seconds) const;
    /// The observer's velocities from the world's, and the reverse [world units per second].
    /// The place is the observer's, in world units.
    [[nodiscard]] VelocityMap seen(double seconds) const;
    [[nodiscard]] VelocityMap unseen(double seconds) const;

    /// The observer's entries in a texture's metadata, and the observer of such entries.
    void describe(openvdb::MetaMap& metadata) const;
    [[nodiscard]] static ReferenceFrameParams describedIn(const openvdb::MetaMap& metadata);

  private:
    /// x = turn · x' + shift
    struct Pose {
        openvdb::Mat3d turn;
        openvdb::Vec3d shift;
    };
    [[nodiscard]] Pose poseAt(double seconds) const;
    [[nodiscard]] openvdb::math::Transform::Ptr moved(const openvdb::math::Transform& transform,
                                                      const Pose& pose) const;

    ReferenceFrameParams mParams;
    openvdb::Mat3d mAxes; // of the velocity's voxels, columns
    openvdb::Vec3d mOrigin, mVelocity, mPoint;
    openvdb::Mat3d mSpin; // ω × as a matrix
};

} // namespace vdblic
