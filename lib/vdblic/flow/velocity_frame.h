#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/distributed/partition.h"
#include "vdblic/field/frame_domain.h"
#include "vdblic/field/units.h"
#include "vdblic/field/velocities.h"
#include "vdblic/flow/reference_frame.h"
#include "vdblic/io/sequence.h"

#include <openvdb/openvdb.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdblic {

/// The unit of stored velocities.
enum class VelocityUnit { kWorldPerSecond, kWorldPerFrame, kVoxelPerSecond, kVoxelPerFrame };
template<>
inline constexpr auto kNames<VelocityUnit> = std::to_array<std::string_view>({"world/s", "world/frame", "voxel/s",
                                                                              "voxel/frame"});

/// Mantaflow stores voxels per unit of its own time: 2.5 units make a second (measured at 24, 30 and 48 fps).
inline constexpr double kMantaflowScale = 2.5;

/// The treatment of velocities that are not finite.
enum class NonFinite { kRefuse, kZero };
template<>
inline constexpr auto kNames<NonFinite> = std::to_array<std::string_view>({"refuse", "zero"});

/// How to find and interpret the velocity in a file.
struct VelocityParams {
    std::string grid;                 ///< name of the Vec3 grid or of three scalars; empty: by convention
    std::optional<VelocityUnit> unit; ///< none: voxel/s for Mantaflow, else world/s
    double scale = 1;                 ///< factor on the values
    NonFinite nonFinite = NonFinite::kRefuse;
    double motion = 1;              ///< factor on displacements; speeds stay
    std::vector<std::string> carry; ///< names of other grids of the file to pass on

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(VelocityParams& params);

/// The interpretation of stored velocities.
struct VelocityConvention {
    VelocityUnit unit = VelocityUnit::kWorldPerSecond;
    double scale = 1;
    bool mantaflow = false; ///< a cache of Blender's Mantaflow
};
/// @param grid of the velocity or its first component, as stored
[[nodiscard]] VelocityConvention conventionOf(const openvdb::GridBase& grid, const VelocityParams& params);

/// Times of a frame [s], as far as metadata state them.
struct FrameTimes {
    std::optional<double> time, dt;
};
/// @param grid of the velocity  @param file metadata for entries that the grid lacks
[[nodiscard]] FrameTimes timesOf(const openvdb::GridBase& grid, const openvdb::MetaMap& file);

/// The velocity at one time, and the voxels of its texture.
struct VelocityFrame : VelocityConvention, FrameTimes {
    VelocityFrame() = default;
    /// A velocity in memory. @param velocity in world units per second, on voxel centres
    VelocityFrame(FrameDomain voxels, openvdb::Vec3SGrid::Ptr velocity)
        : domain(std::move(voxels)), values(std::move(velocity))
    {
    }

    FrameFile file;
    double sourceFrame = 1;         ///< number of the frame; between two frames a fraction
    FrameDomain domain;             ///< null as read from a file; a VelocitySequence chooses it
    std::string gridName;           ///< "velocity", or "vel.x, vel.y, vel.z"
    openvdb::Vec3SGrid::Ptr values; ///< on voxel centres, in the stored unit
    std::string sourceCreator;      ///< file metadata `creator`
    double motion = 1;              ///< VelocityParams::motion
    std::string start;              ///< date of time 0, of the grid's or the file's metadata
    std::string lengthUnit;         ///< of world space, from the same metadata
    openvdb::GridPtrVec carried;
    std::vector<std::string> remarks; ///< choices made on the user's behalf
    std::string stamp;                ///< VelocitySequence::stampOf() just before reading
    double readSeconds = 0;           ///< spent on reading
    /// Whose space velocity, domain and carried grids are in; null: the world's.
    std::shared_ptr<const ReferenceFrame> observer;
    double observedSeconds = 0; ///< since the observer's start

    // If several ranks share the run, values and domain are this rank's part.
    std::shared_ptr<const Partition> partition; ///< null for a process alone
    std::vector<Rim<Space::kVelocity>> rims;    ///< how far each rank's values go beyond its box
    StoredSpeeds largest;                       ///< in the rank's box

    // @param interval seconds from this frame to the next
    [[nodiscard]] FromStored<Space::kWorld, Per::kSecond> toWorldPerSecond(double interval) const;
    [[nodiscard]] FromStored<Space::kVelocity, Per::kFrame> toVoxelsPerFrame(double interval) const;
    /// The largest displacement of an active voxel from this frame to the next [voxels of the velocity].
    [[nodiscard]] double largestDisplacement(double interval) const;

    [[nodiscard]] openvdb::math::Transform::Ptr textureTransform() const
    {
        return domain.refinement.refined(values->transform());
    }
    /// The place of a grid of the frame's space in the world.
    [[nodiscard]] openvdb::math::Transform::Ptr inWorld(const openvdb::math::Transform& grid) const
    {
        return observer ? observer->toWorld(grid, observedSeconds) : grid.copy();
    }
};

/// The part of a velocity to read.
struct VelocityPart {
    VoxelBox<Space::kVelocity> box; ///< whole leaves
    bool verify = true;             ///< whether to verify the file's checksums, which reads all its bytes
};

/// Read the velocity of one file, or of a volume in memory, in any of the conventions of docs/formats.md.
///
/// @throws InputError if there is none, its transform is sheared or a frustum, or a value is not finite; the
///         message names file, grid, first voxel and count
/// @param part to read; leaves outside its box may lack values (LeafBuffer::empty())
/// @return a frame without a domain
[[nodiscard]] VelocityFrame readVelocity(const FrameFile& file, const VelocityParams& params,
                                         const std::optional<VelocityPart>& part = std::nullopt);

} // namespace vdblic
