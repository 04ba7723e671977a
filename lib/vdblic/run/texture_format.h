#pragma once

#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>

#include <string_view>

namespace vdblic {

/// Numbers of the texture and the scalars on disk.
enum class GridPrecision {
    kHalf, ///< 11 significant bits; a scalar outside the range of half precision stays single
    kFloat,
};
[[nodiscard]] GridPrecision parseGridPrecision(std::string_view text); ///< `half` or `float`. @throws ParameterError
[[nodiscard]] std::string_view toString(GridPrecision precision);

/// The voxels that scalars have in a texture file.
enum class ScalarVoxels { kVelocity, kTexture };
[[nodiscard]] ScalarVoxels
parseScalarVoxels(std::string_view text); ///< `velocity` or `texture`. @throws ParameterError
[[nodiscard]] std::string_view toString(ScalarVoxels voxels);

/// How texture files hold their grids.
struct TextureFormat {
    GridPrecision precision = GridPrecision::kHalf;
    VdbCompression compression = VdbCompression::kBlosc;
    ScalarVoxels scalars = ScalarVoxels::kVelocity;
};

/// Mark a grid to be written in half precision, if half precision holds its values: the largest magnitude must lie in
/// 1/16 to 65504, or be 0. Below 1/16, values of a thousandth of the largest would lose bits.
void saveAsHalf(openvdb::FloatGrid& grid);

} // namespace vdblic
