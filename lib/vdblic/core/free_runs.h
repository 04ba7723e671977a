#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace vdblic {

/// The free places of a numbered array, as ranges of neighbours. The cost of taking and returning places does not
/// depend on the number of ranges. Allocates nothing after its construction. Not thread-safe.
class FreeRuns {
  public:
    struct Range {
        std::uint32_t first, count;
    };

    explicit FreeRuns(std::size_t places); ///< @throws std::bad_alloc
    ~FreeRuns();
    FreeRuns(const FreeRuns&) = delete;
    FreeRuns& operator=(const FreeRuns&) = delete;

    /// Give places back. None may be free.
    void add(Range range);
    /// Take the first places of a range that has so many. Where there are many ranges, one of fewer than twice as many
    /// may be missed.
    [[nodiscard]] std::optional<std::uint32_t> take(std::uint32_t count);
    /// Take a whole range.
    [[nodiscard]] std::optional<Range> takeAny();

  private:
    static constexpr std::uint32_t kNone = UINT32_MAX;
    static constexpr std::size_t kLists = 32; // ranges of 2^n places and more, fewer than the next list's

    struct Place {
        std::uint32_t count;         ///< of the range that begins or ends here; 0 at all other places
        std::uint32_t before, after; ///< in the list, where a range begins
    };

    void link(Range range);
    void unlink(Range range);

    std::size_t mPlaces;
    Place* mTable; // untouched parts take no memory
    std::array<std::uint32_t, kLists> mFirst;
};

} // namespace vdblic
