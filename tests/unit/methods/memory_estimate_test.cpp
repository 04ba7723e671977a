#include "vdblic/methods/memory_estimate.h"

#include "vdblic/field/box_domain.h"
#include "vdblic/field/frame_domain.h"
#include "vdblic/methods/method_params.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

// tests/cli/test_memory_estimate.py compares with runs.
TEST(MemoryEstimate, OfDefaultParametersNeedsTheVoxelsOnly)
{
    const FrameDomain frame(boxDomain({256, 256, 256}));
    EXPECT_EQ(kAuflic.bytes({}, frame, {}, false), denseBytes(256.0 * 256 * 256));
}

} // namespace
} // namespace vdblic
