#include "vdblic/run/texture_format.h"

#include "vdblic/field/largest_value.h"

#include <fmt/format.h>

namespace vdblic {

Parameters parametersOf(TextureFormat& params)
{
    return {
        parameter("scalars", "Voxels of magnitude and the other float grids.", params.scalars, {.words = "VOXELS"}),
        parameter("precision", "Precision of texture and scalars in the files.", params.precision,
                  {.words = "NUMBERS"}),
        parameter("compression", "Compression of the files.", params.compression, {.words = "HOW"}),
    };
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
