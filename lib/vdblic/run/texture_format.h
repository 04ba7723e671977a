#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>

#include <string_view>

namespace vdblic {

/// Precision of texture and scalars on disk.
enum class GridPrecision {
    kHalf, ///< 11 significant bits; a scalar outside the range of half precision stays single
    kFloat,
};
template<>
inline constexpr auto kNames<GridPrecision> = std::to_array<std::string_view>({"half", "float"});

/// The voxels of scalars in a texture file.
enum class ScalarVoxels { kVelocity, kTexture };
template<>
inline constexpr auto kNames<ScalarVoxels> = std::to_array<std::string_view>({"velocity", "texture"});

/// The storage of grids in texture files.
struct TextureFormat {
    GridPrecision precision = GridPrecision::kHalf;
    VdbCompression compression = VdbCompression::kBlosc;
    ScalarVoxels scalars = ScalarVoxels::kVelocity;
};
[[nodiscard]] Parameters parametersOf(TextureFormat& params);

/// Mark a grid to be written in half precision if half precision has the range: the largest magnitude must be 0 or lie
/// in 1/16 to 65504. Below 1/16, values of a thousandth of the largest would lose bits.
void saveAsHalf(openvdb::FloatGrid& grid);

} // namespace vdblic
