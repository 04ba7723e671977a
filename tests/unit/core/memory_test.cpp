#include "vdblic/core/memory.h"

#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sys/resource.h>
#include <unistd.h>

namespace vdblic {
namespace {

TEST(Memory, IsWhatTheMachineHasOrLess)
{
    const auto physical = std::uint64_t(::sysconf(_SC_PHYS_PAGES)) * std::uint64_t(::sysconf(_SC_PAGESIZE));
    EXPECT_LE(memoryLimit(), physical);
    EXPECT_GT(memoryLimit(), std::uint64_t(1) << 24);
}

TEST(Memory, IsNoMoreThanTheProcessAllowsItself)
{
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the address sanitizer holds more memory than there is";
#endif
    rlimit before{};
    ::getrlimit(RLIMIT_DATA, &before);
    const rlimit limit{std::min<rlim_t>(rlim_t(1) << 40, before.rlim_max), before.rlim_max};
    ::setrlimit(RLIMIT_DATA, &limit); // more than the memory of the machine: no limit
    const std::uint64_t machine = memoryLimit();
    const rlimit least{rlim_t(1) << 30, before.rlim_max};
    ::setrlimit(RLIMIT_DATA, &least);
    const std::uint64_t limited = memoryLimit();
    ::setrlimit(RLIMIT_DATA, &before);
    EXPECT_EQ(limited, std::min(machine, std::uint64_t(1) << 30));
}

TEST(Memory, IsCheckedBeforeItIsAllocated)
{
    EXPECT_NO_THROW(checkMemory(1e6, "a.vdb", "take a smaller file"));
    EXPECT_NO_THROW(checkVoxels(1000));
    try {
        checkVoxels(std::uint64_t(1) << 60, "grid v");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_TRUE(std::string(error.what())
                        .starts_with("grid v: 1152921504606846976 voxels would take 16777216.0 TiB "
                                     "of memory or more, and "))
            << error.what();
        EXPECT_NE(std::string(error.what()).find("`box`"), std::string::npos);
    }
}

TEST(Memory, IsParsed)
{
    EXPECT_EQ(parseMemory("1"), 1u);
    EXPECT_EQ(parseMemory("123456789"), 123456789u);
    EXPECT_EQ(parseMemory("800M"), std::uint64_t(800) << 20);
    EXPECT_EQ(parseMemory("1.5g"), std::uint64_t(3) << 29);
    EXPECT_EQ(parseMemory("1024T"), std::uint64_t(1) << 50);
    for (const char* text : {"", "0", "-1", "nan", "inf", "1e3", "G", "1GB", "1 G", "0.5", "1025T", "1x",
                             "99999999999999999999", "0x10"}) {
        EXPECT_THROW((void)parseMemory(text), ParameterError) << text;
    }
}

TEST(Memory, IsWrittenForPeople)
{
    EXPECT_EQ(memoryText(0), "0 B");
    EXPECT_EQ(memoryText(1023), "1023 B");
    EXPECT_EQ(memoryText(1536), "1.5 KiB");
    EXPECT_EQ(memoryText(double(std::uint64_t(16) << 30)), "16.0 GiB");
}

} // namespace
} // namespace vdblic
