#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>

#include <string_view>

namespace vdblic {

/// Numbers of the texture and the scalars on disk.
enum class GridPrecision {
    kHalf, ///< 11 significant bits; a scalar outside the range of half precision stays single
    kFloat,
};
template<>
inline constexpr auto kNames<GridPrecision> = std::to_array<std::string_view>({"half", "float"});

/// The voxels that scalars have in a texture file.
enum class ScalarVoxels { kVelocity, kTexture };
template<>
inline constexpr auto kNames<ScalarVoxels> = std::to_array<std::string_view>({"velocity", "texture"});

/// How texture files hold their grids.
struct TextureFormat {
    GridPrecision precision = GridPrecision::kHalf;
    VdbCompression compression = VdbCompression::kBlosc;
    ScalarVoxels scalars = ScalarVoxels::kVelocity;
};
[[nodiscard]] Parameters parametersOf(TextureFormat& params);

/// Mark a grid to be written in half precision, if half precision holds its values: the largest magnitude must lie in
/// 1/16 to 65504, or be 0. Below 1/16, values of a thousandth of the largest would lose bits.
void saveAsHalf(openvdb::FloatGrid& grid);

} // namespace vdblic
