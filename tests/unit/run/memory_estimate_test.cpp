#include "vdblic/run/memory_estimate.h"

#include "vdblic/field/box_domain.h"
#include "vdblic/field/field_domain.h"
#include "vdblic/run/advect_params.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

// Peaks of vdblic_advect on an ABC flow of 256³ voxels, two threads.
TEST(MemoryEstimate, IsWithinAQuarterOfMeasuredRuns)
{
    const FieldDomain frame(boxDomain({256, 256, 256}));
    AdvectParams params;
    EXPECT_NEAR(advectBytes(params, frame) / 1.33e9, 1, 0.25);
    EXPECT_EQ(advectBytes(params, frame), advectBytes(256.0 * 256 * 256));
    params.texture.method = TextureMethod::kUflic;
    EXPECT_NEAR(advectBytes(params, frame) / 2.79e9, 1, 0.25);
}

} // namespace
} // namespace vdblic
