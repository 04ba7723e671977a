#include "vdblic/core/memory.h"
#include "vdblic/core/scratch_memory.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <malloc.h>
#include <new>

namespace {

using vdblic::ScratchMemory;

// Once ordinary memory is used up, small objects are paged, too, aligned for any usual type.
constexpr std::size_t kLeastPaged = 2048, kMostAlignment = 128;

// Objects of stricter alignment are bricks, which are in use all the time: they stay in ordinary memory up to a share
// of the limit. Those from before the scratch file began are not counted.
constexpr std::int64_t kShare = 8;
std::atomic<std::int64_t> gAligned = 0;

void countAligned(std::int64_t sign, void* memory)
{
    if (ScratchMemory::isBegun()) gAligned += sign * std::int64_t(::malloc_usable_size(memory));
}

bool isShareUsedUp(std::size_t bytes)
{
    if (!ScratchMemory::isBegun()) return false;
    static const auto most = std::int64_t(vdblic::memoryLimit()) / kShare;
    return gAligned + std::int64_t(bytes) > most;
}

/// Memory in the scratch file, for requests that ordinary memory cannot serve.
void* lastMemory(std::size_t bytes, std::size_t alignment)
{
    return alignment <= kMostAlignment ? ScratchMemory::allocate(std::max(bytes, kLeastPaged)) : nullptr;
}

/// Call the program's new-handler. @throws std::bad_alloc if it has none
void handleLack()
{
    const std::new_handler handler = std::get_new_handler();
    if (!handler) throw std::bad_alloc();
    handler();
}

void* alignedMemoryFor(std::size_t bytes, std::size_t alignment)
{
    if (isShareUsedUp(bytes)) {
        if (void* const paged = lastMemory(bytes, alignment)) return paged;
    }
    for (;; handleLack()) {
        if (void* const memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment)) {
            countAligned(1, memory);
            return memory;
        }
        if (void* const paged = lastMemory(bytes, alignment)) return paged;
    }
}

void* memoryFor(std::size_t bytes)
{
    if (void* const paged = ScratchMemory::allocate(bytes)) return paged;
    for (;; handleLack()) {
        if (void* const memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
        if (void* const paged = lastMemory(bytes, 1)) return paged;
    }
}

/// Free memory of the scratch file. An expression that ends in a delete keeps its errno. @return whether it was such
bool releasePaged(void* memory)
{
    if (!ScratchMemory::isBegun()) return false;
    const int before = errno;
    const bool wasPaged = ScratchMemory::release(memory);
    errno = before;
    return wasPaged;
}

void releaseAligned(void* memory)
{
    if (!memory || releasePaged(memory)) return;
    countAligned(-1, memory);
    std::free(memory);
}

void release(void* memory)
{
    if (!releasePaged(memory)) std::free(memory);
}

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
