#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace vdblic {

/// The free places of a numbered array, as ranges. The cost of taking and returning places does not depend on the
/// number of ranges. Allocates nothing after its construction. Not thread-safe.
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
    /// Take `count` places from the front of a range. Among many ranges, one shorter than 2 · count may be missed.
    [[nodiscard]] std::optional<std::uint32_t> take(std::uint32_t count);
    /// Take a whole range.
    [[nodiscard]] std::optional<Range> takeAny();

  private:
    static constexpr std::uint32_t kNone = UINT32_MAX;
    static constexpr std::size_t kLists = 32; // list n holds ranges of 2ⁿ places and more, below 2ⁿ⁺¹

    struct Place {
        std::uint32_t count;         ///< length of the range that begins or ends here; else 0
        std::uint32_t before, after; ///< neighbours in the list, if a range begins here
    };

    void link(Range range);
    void unlink(Range range);

    std::size_t mPlaces;
    Place* mTable; // untouched pages take no memory
    std::array<std::uint32_t, kLists> mFirst;
};

} // namespace vdblic
