#include "vdblic/core/crash_litter.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <mutex>
#include <unistd.h>

namespace vdblic {
namespace {

/// Plain data, which a signal handler may read.
struct Slot {
    std::array<char, 4096> path{};
    bool isTaken = false;
    volatile sig_atomic_t isReady = 0;
};
std::array<Slot, 4> gSlots;
std::mutex gMutex;

} // namespace

CrashLitter::CrashLitter(const std::string& path) : mSlot(gSlots.size())
{
    const std::lock_guard lock(gMutex);
    auto* const slot = std::find_if(gSlots.begin(), gSlots.end(), [](const Slot& one) { return !one.isTaken; });
    if (slot == gSlots.end() || path.size() >= slot->path.size()) return;
    std::memcpy(slot->path.data(), path.c_str(), path.size() + 1);
    slot->isTaken = true;
    slot->isReady = 1;
    mSlot = std::size_t(slot - gSlots.begin());
}

CrashLitter::~CrashLitter()
{
    if (mSlot == gSlots.size()) return;
    const std::lock_guard lock(gMutex);
    gSlots[mSlot].isReady = 0;
    gSlots[mSlot].isTaken = false;
}

void removeCrashLitter() noexcept
{
    for (const Slot& slot : gSlots) {
        if (slot.isReady) ::unlink(slot.path.data());
    }
}

} // namespace vdblic
