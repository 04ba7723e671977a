#pragma once

#include "vdblic/io/sequence.h"
#include "vdblic/render/camera.h"

#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// The bounds of a sequence's active voxels.
struct SequenceBounds {
    Corners box; ///< around all frames' voxels, in world space; along the grid's axes if all share a transform
    FrameFile firstFilled; ///< the first frame that has any
    bool steady = true;    ///< every frame has the same bounds
};

/// Find the bounds of a grid over a sequence from the headers of its files. Files without the grid and unreadable files
/// are ignored; rendering reports them.
/// @return nothing if no frame has an active voxel
[[nodiscard]] std::optional<SequenceBounds> sequenceBounds(const std::vector<FrameFile>& files,
                                                           const std::string& gridName);

} // namespace vdblic
