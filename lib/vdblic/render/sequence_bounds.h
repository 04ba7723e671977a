#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/io/sequence.h"
#include "vdblic/io/vdb_header.h"

#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// The bounds of a sequence's active voxels.
struct SequenceBounds {
    Corners box; ///< around all frames' voxels, in world space; along the grid's axes if all share a transform
    FrameFile firstFilled; ///< the first frame that has any
};

/// The header of a frame's texture, its box computed from the voxels if the file does not hold it; nothing if the grid
/// cannot be read.
/// @param texture name of the grid; empty: by the file's metadata (textureName())
[[nodiscard]] std::optional<GridHeader> textureHeader(const FrameFile& file, const std::string& texture);

/// The corners of the voxels in a box, in world space.
[[nodiscard]] Corners cornersOf(const openvdb::CoordBBox& box, const openvdb::math::Transform& transform);

/// Find the bounds of the textures of a sequence from the headers of its files. Files without a texture and unreadable
/// files are ignored; rendering reports them.
/// @param texture name of the grid; empty: by each file's metadata
/// @return nullopt if no frame has an active voxel
[[nodiscard]] std::optional<SequenceBounds> sequenceBounds(const std::vector<FrameFile>& files,
                                                           const std::string& texture);

} // namespace vdblic
