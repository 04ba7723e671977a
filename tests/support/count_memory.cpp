/// Preloaded into a tool, counts the memory that it allocates: at the end the most that it held at a time, in bytes, is
/// in the file that VDBLIC_COUNTED names. What the allocator adds, keeps or leaves unused does not count.
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <malloc.h>

// The allocator of glibc, below those that are defined here.
void* systemMalloc(std::size_t bytes) asm("__libc_malloc");
void* systemCalloc(std::size_t count, std::size_t bytes) asm("__libc_calloc");
void* systemRealloc(void* memory, std::size_t bytes) asm("__libc_realloc");
void* systemMemalign(std::size_t alignment, std::size_t bytes) asm("__libc_memalign");
void systemFree(void* memory) asm("__libc_free");

namespace {

std::atomic<long> gHeld = 0, gMost = 0;

void count(long bytes)
{
    const long held = gHeld += bytes;
    long most = gMost;
    while (held > most && !gMost.compare_exchange_weak(most, held)) {
    }
}

void* counted(void* memory)
{
    if (memory) count(long(::malloc_usable_size(memory)));
    return memory;
}

struct Report {
    ~Report()
    {
        const char* const path = std::getenv("VDBLIC_COUNTED");
        std::FILE* const file = path ? std::fopen(path, "w") : nullptr;
        if (!file) return;
        std::fprintf(file, "%ld\n", gMost.load());
        std::fclose(file);
    }
};
const Report gReport;

} // namespace

extern "C" {

void* malloc(std::size_t bytes)
{
    return counted(systemMalloc(bytes));
}

void* calloc(std::size_t count, std::size_t bytes)
{
    return counted(systemCalloc(count, bytes));
}

void* realloc(void* memory, std::size_t bytes)
{
    if (memory) count(-long(::malloc_usable_size(memory)));
    return counted(systemRealloc(memory, bytes));
}

void* memalign(std::size_t alignment, std::size_t bytes)
{
    return counted(systemMemalign(alignment, bytes));
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes)
{
    return counted(systemMemalign(alignment, bytes));
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes)
{
    *memory = counted(systemMemalign(alignment, bytes));
    return *memory ? 0 : ENOMEM;
}

void free(void* memory)
{
    if (memory) count(-long(::malloc_usable_size(memory)));
    systemFree(memory);
}
}
