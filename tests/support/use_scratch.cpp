/// What the tools' operator new does where the memory is used up: use_scratch FOLDER. Status 0 if it is as it should
/// be.

#include "vdblic/core/scratch_memory.h"

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <new>
#include <sys/resource.h>

namespace {

int gFaults = 0;

void expect(bool isTrue, const char* what)
{
    if (isTrue) return;
    std::fprintf(stderr, "use_scratch: not so: %s\n", what);
    ++gFaults;
}

/// Memory of an alignment; null if there is none.
void* alignedMemory(std::size_t bytes, std::size_t alignment)
{
    try {
        return ::operator new(bytes, std::align_val_t(alignment));
    } catch (const std::bad_alloc&) {
        return nullptr;
    }
}

} // namespace

int main(int argc, char** argv)
{
    using vdblic::ScratchMemory;
    if (argc != 2) return 2;
    constexpr std::uint64_t kLimit = std::uint64_t(1) << 30;
    constexpr std::size_t kMuch = std::size_t(256) << 20;
    auto& memory = *new ScratchMemory(argv[1], kLimit, 1);
    vdblic::paging::setMemory(memory);
    memory.expectFiles(double(kLimit));
    expect(ScratchMemory::isBegun(), "memory is paged");

    int* const number = new int[1000];
    expect(memory.failureAt(number) != nullptr, "an array lies in the scratch file");
    errno = ERANGE;
    delete[] number;
    expect(errno == ERANGE, "delete keeps errno");
    int* const many = new int[kMuch / sizeof(int)]; // given up when it is freed, by system calls
    errno = ERANGE;
    delete[] many;
    expect(errno == ERANGE, "delete of a large array keeps errno");

    rlimit data{};
    ::getrlimit(RLIMIT_DATA, &data);
    data.rlim_cur = 1; // ordinary memory holds what it has, and no more
    ::setrlimit(RLIMIT_DATA, &data);
    for (const std::size_t alignment : {32, 64, 128, 256, 512, 4096}) {
        for (int i = 0; i < 1000; ++i) {
            void* const made = alignedMemory(3000, alignment);
            expect(reinterpret_cast<std::uintptr_t>(made) % alignment == 0, "memory is aligned as it is asked for");
            expect(made || alignment > 128, "memory of usual alignment is there");
        }
    }
    return gFaults;
}
