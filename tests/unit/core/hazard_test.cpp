#include "vdblic/core/hazard.h"

#include <gtest/gtest.h>

#include <string>

namespace vdblic {
namespace {

std::string gHazardCalls;

TEST(Hazard, CallsTheHooksOnceForNestedHazards)
{
    setHazardHooks({[](const char* file, std::uint64_t) noexcept { gHazardCalls += std::string("enter ") + file; },
                    []() noexcept { gHazardCalls += ", leave; "; }});
    {
        const Hazard outer("a", 1);
        const Hazard inner("b", 1);
    }
    const Hazard next("c", 1);
    setHazardHooks({});
    EXPECT_EQ(gHazardCalls, "enter a, leave; enter c");
}

} // namespace
} // namespace vdblic
