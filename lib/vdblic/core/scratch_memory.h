#pragma once

#include "vdblic/core/paged_heap.h"
#include "vdblic/core/paging.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>

namespace vdblic {

class ResidentKeeper;

/// Memory in a scratch file: allocations beyond the memory limit lie on disk, and only the pages in use are resident.
///
/// The file is mapped into the process and has no name, so nothing is left of it after the process, however that ends.
/// The file, and the thread that keeps the process's resident memory below the limit, begin only when makeRoom() or
/// expectFiles() announces that the work needs them; until then the program's operator new tests one pointer.
///
/// Lives as long as the process, because memory is freed until its very end. Thread-safe.
class ScratchMemory : public paging::Memory {
  public:
    /// @param folder  of the scratch file
    /// @param limit   of the process's resident memory [bytes]
    /// @param inFiles peak bytes of input resident at once, as a multiple of one input file
    ScratchMemory(std::filesystem::path folder, std::uint64_t limit, double inFiles);

    bool makeRoom(double bytes) override;
    void expectFiles(double bytes) override;
    [[nodiscard]] bool mayHold(double bytes) const override;
    void breathe(std::size_t bytes) override;
    [[nodiscard]] const char* problem() const noexcept override;
    [[nodiscard]] const char* failureAt(const void* address) const noexcept override;

    /// For the program's operator new: memory for an object, aligned as by operator new, and to 128 bytes if it has
    /// more than 1 KiB; null if paging has not begun, the object is small, or the scratch file cannot grow (problem()).
    [[nodiscard]] static void* allocate(std::size_t bytes) noexcept
    {
        ScratchMemory* const begun = sBegun.load(std::memory_order_acquire);
        return __builtin_expect(begun != nullptr, 0) ? begun->take(bytes) : nullptr;
    }
    /// Free memory of allocate(). @return whether allocate() had made it
    static bool release(void* memory) noexcept
    {
        ScratchMemory* const begun = sBegun.load(std::memory_order_acquire);
        return __builtin_expect(begun != nullptr, 0) && begun->giveBack(memory);
    }
    [[nodiscard]] static bool isBegun() { return sBegun.load(std::memory_order_acquire) != nullptr; }

  private:
    void begin();
    void noteProblem() noexcept;
    [[nodiscard]] void* take(std::size_t bytes) noexcept;
    bool giveBack(void* memory) noexcept;
    [[nodiscard]] std::uintmax_t freeBytes() const;

    static std::atomic<ScratchMemory*> sBegun;

    const std::filesystem::path mFolder;
    const std::uint64_t mLimit;
    const double mInFiles;
    std::mutex mMutex; // guards begin()
    PagedHeap* mHeap = nullptr;
    ResidentKeeper* mKeeper = nullptr;
    std::mutex mProblemMutex;
    std::array<char, 4600> mProblem{}, mFailure{}; // texts for signal handlers
    std::atomic<bool> mHasProblem = false;
};

} // namespace vdblic
