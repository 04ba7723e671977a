#pragma once

#include "vdblic/io/sequence.h"

#include <openvdb/openvdb.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// What a stored velocity of 1 means.
enum class VelocityUnit { kWorldPerSecond, kWorldPerFrame, kVoxelPerSecond, kVoxelPerFrame };

/// `world/s`, `world/frame`, `voxel/s` or `voxel/frame`. @throws ParameterError on anything else
[[nodiscard]] VelocityUnit parseVelocityUnit(std::string_view text);
[[nodiscard]] std::string_view toString(VelocityUnit unit);

/// What to do with velocities that are not finite numbers.
enum class NonFinite { kRefuse, kZero };

/// How to find and understand the velocity in a file.
struct VelocityParams {
    std::string grid;                 ///< name of the Vec3 grid or of three scalars; empty: by convention
    std::optional<VelocityUnit> unit; ///< what the values mean; nothing: world/s, or as Mantaflow means them
    double scale = 1;                 ///< factor on the values
    NonFinite nonFinite = NonFinite::kRefuse;
    std::vector<std::string> carry; ///< other grids of the file to be handed on

    void validate() const; ///< @throws ParameterError
};

/// The velocity of one frame.
struct VelocityFrame {
    FrameFile file;
    std::string gridName;           ///< as found: "velocity", or "vel.x, vel.y, vel.z"
    openvdb::Vec3SGrid::Ptr values; ///< on voxel centres, as stored; staggered input is averaged to the centres
    VelocityUnit unit = VelocityUnit::kWorldPerSecond;
    double scale = 1;
    std::optional<double> time, dt; ///< seconds, from metadata
    bool mantaflow = false;         ///< a cache of Blender's Mantaflow
    std::string sourceCreator;      ///< what the file says it was made by
    openvdb::GridPtrVec carried;
    std::vector<std::string> remarks; ///< choices made for the user that should be known

    /// Matrix from stored values to world units per second. @param interval seconds between frames
    [[nodiscard]] openvdb::Mat3d toWorldPerSecond(double interval) const;
    /// Matrix from stored values to voxels per step along the index axes. @param interval seconds of the step
    [[nodiscard]] openvdb::Mat3d toVoxelsPerStep(double interval) const;
    /// The longest way a voxel's fluid goes in a step, in voxels. @param interval seconds of the step
    [[nodiscard]] double largestDisplacement(double interval) const;
};

/// Read the velocity of one file in any of the conventions of docs/formats.md.
///
/// @throws InputError if there is none, its transform is sheared or a frustum, or a value is not finite; the
///         message names file, grid, first voxel and count
[[nodiscard]] VelocityFrame readVelocity(const FrameFile& file, const VelocityParams& params);

} // namespace vdblic
