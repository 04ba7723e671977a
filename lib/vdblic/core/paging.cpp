#include "vdblic/core/paging.h"

#include "vdblic/core/errors.h"

namespace vdblic::paging {

std::atomic<Memory*> detail::gMemory = nullptr;

namespace {

Memory* memory() noexcept
{
    return detail::gMemory.load(std::memory_order_acquire);
}

} // namespace

void setMemory(Memory& memory)
{
    detail::gMemory = &memory;
}

bool makeRoom(double bytes)
{
    return memory() && memory()->makeRoom(bytes);
}

void expectFiles(double bytes)
{
    if (memory()) memory()->expectFiles(bytes);
}

bool mayHold(double bytes)
{
    return memory() && memory()->mayHold(bytes);
}

const char* problem() noexcept
{
    return memory() ? memory()->problem() : nullptr;
}

const char* failureAt(const void* address) noexcept
{
    return memory() ? memory()->failureAt(address) : nullptr;
}

void checkScratch()
{
    if (const char* const text = problem()) throw OutputError(text);
}

} // namespace vdblic::paging
