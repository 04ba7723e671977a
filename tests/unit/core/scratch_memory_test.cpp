#include "vdblic/core/scratch_memory.h"

#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>

namespace vdblic {
namespace {

/// Do work in a process of its own, whose memory it changes for ever. @return whether it returns true
template<typename Work>
bool holdsAlone(const Work& work)
{
    const pid_t child = ::fork();
    if (child == 0) ::_exit(work() ? 0 : 1);
    int status = 0;
    return ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::ptrdiff_t threads()
{
    const std::filesystem::directory_iterator all("/proc/self/task");
    return std::distance(begin(all), end(all));
}

constexpr std::uint64_t kLimit = std::uint64_t(1) << 30;

TEST(ScratchMemory, WithoutPressureThereIsNoThreadNoFileAndNoPlace)
{
    const TemporaryFolder folder;
    EXPECT_TRUE(holdsAlone([&] {
        const std::ptrdiff_t before = threads();
        auto& memory = *new ScratchMemory(folder / "missing", kLimit, 1); // where no file could be made
        paging::setMemory(memory);
        const bool hasRoom = paging::makeRoom(0.7 * double(kLimit));
        paging::expectFiles(0.7 * double(kLimit));
        paging::breathe(kLimit);
        return !hasRoom && !ScratchMemory::isBegun() && ScratchMemory::allocate(4096) == nullptr &&
               !ScratchMemory::release(&memory) && threads() == before;
    }));
}

TEST(ScratchMemory, BeginsOnceWithOneThread)
{
    const TemporaryFolder folder;
    EXPECT_TRUE(holdsAlone([&] {
        const std::ptrdiff_t before = threads();
        paging::setMemory(*new ScratchMemory(folder.path(), kLimit, 0.5));
        paging::expectFiles(1.5 * double(kLimit)); // of which the job holds a half
        if (ScratchMemory::isBegun()) return false;
        paging::expectFiles(2.0 * double(kLimit));
        paging::expectFiles(2.0 * double(kLimit));
        void* const object = ScratchMemory::allocate(4096);
        return object && ScratchMemory::release(object) && threads() == before + 1;
    }));
}

TEST(ScratchMemory, IsNoMatterOfProgramsWithoutIt)
{
    EXPECT_TRUE(holdsAlone([] {
        paging::expectFiles(1e18);
        paging::breathe(kLimit);
        return !paging::makeRoom(1e18) && !paging::mayHold(1) && !paging::problem() && !paging::failureAt(&kLimit);
    }));
}

} // namespace
} // namespace vdblic
