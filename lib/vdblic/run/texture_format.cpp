#include "vdblic/run/texture_format.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/largest_value.h"

#include <fmt/format.h>

namespace vdblic {

GridPrecision parseGridPrecision(std::string_view text)
{
    if (text == "half") return GridPrecision::kHalf;
    if (text == "float") return GridPrecision::kFloat;
    throw ParameterError(fmt::format("precision '{}' is neither half nor float", text));
}

std::string_view toString(GridPrecision precision)
{
    return precision == GridPrecision::kHalf ? "half" : "float";
}

ScalarVoxels parseScalarVoxels(std::string_view text)
{
    if (text == "velocity") return ScalarVoxels::kVelocity;
    if (text == "texture") return ScalarVoxels::kTexture;
    throw ParameterError(fmt::format("the voxels '{}' of the scalars are neither velocity nor texture", text));
}

std::string_view toString(ScalarVoxels voxels)
{
    return voxels == ScalarVoxels::kVelocity ? "velocity" : "texture";
}

void saveAsHalf(openvdb::FloatGrid& grid)
{
    constexpr float kLeast = 1.0f / 16, kMost = 65504;
    const NumberRow magnitudes = largestValues(grid.tree(), [](const NumberRow& values) {
        return NumberRow{values.numbers < 0 ? -values.numbers : values.numbers};
    });
    const float largest = largestLane(magnitudes.numbers);
    grid.setSaveFloatAsHalf(largest == 0 || (largest >= kLeast && largest <= kMost));
}

} // namespace vdblic
