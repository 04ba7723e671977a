/// Preloaded into a tool, counts the memory that it allocates: at the end the most that it held at a time, in bytes, is
/// in the file that VDBLIC_COUNTED names. What the allocator adds, keeps or leaves unused does not count.
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <malloc.h>

extern "C" {
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* memory, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);
void __libc_free(void* memory);
}

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
    return counted(__libc_malloc(bytes));
}

void* calloc(std::size_t count, std::size_t bytes)
{
    return counted(__libc_calloc(count, bytes));
}

void* realloc(void* memory, std::size_t bytes)
{
    if (memory) count(-long(::malloc_usable_size(memory)));
    return counted(__libc_realloc(memory, bytes));
}

void* memalign(std::size_t alignment, std::size_t bytes)
{
    return counted(__libc_memalign(alignment, bytes));
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes)
{
    return counted(__libc_memalign(alignment, bytes));
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes)
{
    *memory = counted(__libc_memalign(alignment, bytes));
    return *memory ? 0 : ENOMEM;
}

void free(void* memory)
{
    if (memory) count(-long(::malloc_usable_size(memory)));
    __libc_free(memory);
}
}
