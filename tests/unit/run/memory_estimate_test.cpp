#include "vdblic/run/memory_estimate.h"

#include "vdblic/field/box_domain.h"
#include "vdblic/field/field_domain.h"
#include "vdblic/run/advect_params.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

// tests/cli/test_memory_estimate.py compares with runs.
TEST(MemoryEstimate, OfDefaultParametersNeedsTheVoxelsOnly)
{
    const FieldDomain frame(boxDomain({256, 256, 256}));
    EXPECT_EQ(advectBytes({}, frame), advectBytes(256.0 * 256 * 256));
}

} // namespace
} // namespace vdblic
