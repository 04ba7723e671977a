#include "vdblic/core/system_memory.h"

#include "vdblic/core/memory.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <cstddef>
#include <cstring>

namespace vdblic {
namespace {

TEST(SystemMemory, OfTheProcessGrowsByWhatItTakes)
{
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the address sanitizer holds more memory than there is";
#endif
    constexpr std::size_t kTaken = 64 << 20, kOthers = 4 << 20;
    const ProcessMemory before = processMemory();
    void* const taken = ::mmap(nullptr, kTaken, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(taken, MAP_FAILED);
    std::memset(taken, 1, kTaken);
    const ProcessMemory after = processMemory();
    ::munmap(taken, kTaken);
    EXPECT_NEAR(double(after.resident), double(before.resident + kTaken), kOthers);
    EXPECT_NEAR(double(after.data), double(before.data + kTaken), kOthers);
    EXPECT_NEAR(double(after.files), double(before.files), kOthers);
    EXPECT_GT(before.files, 0u);
}

TEST(SystemMemory, ThatIsFreeIsLessThanTheMachineHas)
{
    EXPECT_GT(freeMemory(), std::uint64_t(1) << 24);
    EXPECT_LT(freeMemory(), machineMemory() < groupMemoryLimit() ? machineMemory() : UINT64_MAX);
}

} // namespace
} // namespace vdblic
