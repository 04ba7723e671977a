#pragma once

#include "vdblic/field/domain.h"

#include <array>
#include <cstdint>
#include <memory>

namespace vdblic {

/// The default voxel size in world units, as in OpenVDB and Houdini.
inline constexpr double kDefaultVoxelSize = 0.1;

/// The most voxels a box may have.
inline constexpr std::int64_t kMaxBoxVoxels = 4'000'000'000;

/// Voxels along x, y and z of a box that begins at index (0, 0, 0).
using BoxSize = std::array<int, 3>;

/// @throws ParameterError if a side is not positive or too long, or the box has more than kMaxBoxVoxels voxels
void checkBoxSize(const BoxSize& size);

/// @throws ParameterError if the voxel size is not a number from 0.0001 to 10000, the range that all readers handle
void checkVoxelSize(double voxelSize);

/// The domain of all voxels of a box. @throws ParameterError of checkBoxSize(); InputError if they exceed the memory
[[nodiscard]] std::shared_ptr<const Domain> boxDomain(const BoxSize& size);

} // namespace vdblic
