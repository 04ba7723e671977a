#pragma once

#include "vdblic/core/free_runs.h"
#include "vdblic/core/scratch_file.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

namespace vdblic {

/// A heap in a scratch file: objects of one size lie together, in the order in which a thread allocated them.
///
/// The bookkeeping lies apart from the objects: allocating and freeing touch no page of the file. Thread-safe.
/// Allocates nothing after its construction, because operator new calls it.
class PagedHeap {
  public:
    static constexpr std::size_t kRun = std::size_t(1) << 20; ///< bytes of a run: objects of one size, or one large one
    static constexpr std::size_t kLeast = 96;                 ///< bytes of an object; smaller ones stay in memory

    explicit PagedHeap(ScratchFile& file); ///< @param file must outlive this
    ~PagedHeap();
    PagedHeap(const PagedHeap&) = delete;
    PagedHeap& operator=(const PagedHeap&) = delete;

    /// Memory aligned for any object of fundamental type; null if the file cannot grow.
    [[nodiscard]] void* allocate(std::size_t bytes) noexcept;
    std::size_t release(void* memory) noexcept; ///< @return bytes of the object's place
    [[nodiscard]] bool owns(const void* memory) const
    {
        const auto* const address = static_cast<const char*>(memory);
        return address >= mBegin && address < mEnd;
    }

    /// Grow the file on disk to `bytes`. @return 0, or an errno
    [[nodiscard]] int reserve(std::size_t bytes) noexcept;
    /// The errno of the file's failed growth, or 0.
    [[nodiscard]] int problem() const { return mProblem; }

    /// Evict runs from resident memory.
    /// @param first, count may reach beyond the end
    void letGo(std::size_t first, std::size_t count) const noexcept;
    [[nodiscard]] std::size_t runs() const { return mTop; } ///< runs ever used

  private:
    static constexpr std::uint32_t kNone = UINT32_MAX;
    static constexpr std::size_t kMostObjects = kRun / kLeast, kWord = 64, kWords = kMostObjects / kWord + 1;
    static constexpr std::size_t kFine = 1024, kFineStep = 16, kSteps = 8, kOctaves = 9; // to half a run
    static constexpr std::size_t kSizes = (kFine - kLeast) / kFineStep + 1 + kSteps * kOctaves;
    static constexpr std::size_t kShards = 8; // each thread allocates in the runs of one shard

    enum class Use : std::uint8_t { kFree, kObjects, kLarge };
    struct Run {
        std::uint32_t before, after;   ///< neighbours in its list
        std::uint32_t size;            ///< size class of the objects; for a large object its number of runs
        std::uint32_t shard, capacity; ///< of objects
        std::uint32_t used, firstFree; ///< objects in use; first word that may have a free place
        std::array<std::uint64_t, kWords> taken;
    };
    struct List {
        std::uint32_t first = kNone, last = kNone;
    };
    struct Shelf { ///< runs with a free place, of one size class
        std::mutex mutex;
        List runs;
    };

    [[nodiscard]] static std::size_t sizeNumber(std::size_t bytes);
    [[nodiscard]] static std::size_t sizeOf(std::size_t number);
    [[nodiscard]] Shelf& shelf(std::size_t shard, std::size_t size) { return mShelves[shard * kSizes + size]; }
    void prepend(List& list, std::uint32_t run);
    void append(List& list, std::uint32_t run);
    void remove(List& list, std::uint32_t run);
    [[nodiscard]] std::uint32_t takeRuns(std::size_t count, Use use) noexcept;
    [[nodiscard]] std::uint32_t takeFree(std::size_t count) noexcept;
    void giveBack(std::uint32_t first, std::size_t count) noexcept;
    [[nodiscard]] void* place(std::size_t run, std::size_t offset) const { return mBegin + run * kRun + offset; }

    ScratchFile& mFile;
    char *mBegin, *mEnd;
    Run* mRuns; // untouched ones take no memory
    std::unique_ptr<std::atomic<Use>[]> mUse;
    std::unique_ptr<Shelf[]> mShelves;
    std::mutex mMutex;      // guards the members below
    FreeRuns mWarm, mEmpty; // free runs with resident pages; with discarded pages
    std::size_t mWarmRuns = 0;
    std::atomic<std::size_t> mTop = 0;
    std::atomic<int> mProblem = 0;
};

} // namespace vdblic
