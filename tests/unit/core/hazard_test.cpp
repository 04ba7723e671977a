#include "vdblic/core/hazard.h"

#include <gtest/gtest.h>

#include <string>

namespace vdblic {
namespace {

std::string gHazardCalls;

TEST(Hazard, CallsTheHooksOnceForNestedHazards)
{
    setHazardHooks({[](const char* file, std::uint64_t, const char* library) noexcept {
                        gHazardCalls += std::string("enter ") + file + " with " + library;
                    },
                    []() noexcept { gHazardCalls += ", leave; "; }});
    {
        const Hazard outer("a", 1);
        const Hazard inner("b", 1);
    }
    const Hazard next("c", 1, "HDF5");
    setHazardHooks({});
    EXPECT_EQ(gHazardCalls, "enter a with OpenVDB, leave; enter c with HDF5");
}

} // namespace
} // namespace vdblic
