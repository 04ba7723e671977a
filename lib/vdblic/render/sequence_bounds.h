#pragma once

#include "vdblic/io/sequence.h"
#include "vdblic/render/camera.h"

#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// Where a sequence has active voxels.
struct SequenceBounds {
    Corners box;           ///< of all frames' voxels in world space; along the grid's axes if all share a transform
    FrameFile firstFilled; ///< the first frame that has any
};

/// Find the bounds of a grid over a sequence from the headers of its files; files that have no such grid or cannot be
/// read have no say: they are reported when they are rendered.
/// @return nothing if no frame has an active voxel
[[nodiscard]] std::optional<SequenceBounds> sequenceBounds(const std::vector<FrameFile>& files,
                                                           const std::string& gridName);

} // namespace vdblic
