#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <malloc.h>
#include <new>

namespace {

// Objects of stricter alignment are bricks, which are in use all the time: they stay in ordinary memory up to a share
// of the limit.
constexpr std::int64_t kShare = 8;
std::atomic<std::int64_t> gAligned = 0;
// Where ordinary memory is used up, small objects are paged, too, in places that suit any alignment in use.
constexpr std::size_t kLeastPaged = 2048;

void* alignedMemoryFor(std::size_t bytes, std::size_t alignment)
{
    if (vdblic::paging::isOn()) {
        static const auto most = std::int64_t(vdblic::memoryLimit()) / kShare;
        constexpr std::size_t kMostAlignment = 128;
        if (gAligned + std::int64_t(bytes) > most && alignment <= kMostAlignment) {
            if (void* const paged = vdblic::paging::allocate(std::max(bytes, kLeastPaged))) return paged;
        }
    }
    for (;;) {
        if (void* const memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment)) {
            gAligned += std::int64_t(::malloc_usable_size(memory));
            return memory;
        }
        if (void* const paged = vdblic::paging::allocate(std::max(bytes, kLeastPaged))) return paged;
        const std::new_handler handler = std::get_new_handler();
        if (!handler) throw std::bad_alloc();
        handler();
    }
}

void releaseAligned(void* memory)
{
    if (!memory || vdblic::paging::release(memory)) return;
    gAligned -= std::int64_t(::malloc_usable_size(memory));
    std::free(memory);
}

void* memoryFor(std::size_t bytes)
{
    if (void* const paged = vdblic::paging::allocate(bytes)) return paged;
    for (;;) {
        if (void* const memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
        if (void* const paged = vdblic::paging::allocate(std::max(bytes, kLeastPaged))) return paged;
        const std::new_handler handler = std::get_new_handler();
        if (!handler) throw std::bad_alloc();
        handler();
    }
}

void release(void* memory)
{
    if (!vdblic::paging::release(memory)) std::free(memory);
}

[[maybe_unused]] const bool kIsLent = (vdblic::paging::lend(), true);

} // namespace

void* operator new(std::size_t bytes)
{
    return memoryFor(bytes);
}
void* operator new[](std::size_t bytes)
{
    return memoryFor(bytes);
}
void operator delete(void* memory) noexcept
{
    release(memory);
}
void operator delete[](void* memory) noexcept
{
    release(memory);
}
void operator delete(void* memory, std::size_t /*bytes*/) noexcept
{
    release(memory);
}
void operator delete[](void* memory, std::size_t /*bytes*/) noexcept
{
    release(memory);
}

void* operator new(std::size_t bytes, std::align_val_t alignment)
{
    return alignedMemoryFor(bytes, std::size_t(alignment));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment)
{
    return alignedMemoryFor(bytes, std::size_t(alignment));
}
void operator delete(void* memory, std::align_val_t /*alignment*/) noexcept
{
    releaseAligned(memory);
}
void operator delete[](void* memory, std::align_val_t /*alignment*/) noexcept
{
    releaseAligned(memory);
}
void operator delete(void* memory, std::size_t /*bytes*/, std::align_val_t /*alignment*/) noexcept
{
    releaseAligned(memory);
}
void operator delete[](void* memory, std::size_t /*bytes*/, std::align_val_t /*alignment*/) noexcept
{
    releaseAligned(memory);
}
