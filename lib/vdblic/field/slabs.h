#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/refinement.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace vdblic {

/// A domain's local leaves in slabs across its longest axis. Work with a reach of a few leaves can sweep over a large
/// domain with only the nearby slabs in memory.
///
/// Slabs are as thin as possible with enough leaves for many threads; a small domain is one slab. Immutable; any number
/// of threads may read.
class Slabs {
  public:
    using Leaves = Domain::Leaves;

    /// @param refinement of the domain: no leaf of the velocity lies under two slabs
    explicit Slabs(const Domain& domain, const Refinement& refinement = {});

    /// The fewest leaves of a slab, by the number of threads, in a domain that has as many.
    [[nodiscard]] static std::size_t fewestLeaves();

    /// The leaves of the velocity's domain under each slab of a refined domain. @param refined made with `refinement`
    Slabs(const Slabs& refined, const Domain& velocity, const Refinement& refinement);

    [[nodiscard]] int axis() const { return mAxis; } ///< across which the slabs lie: the domain's longest
    [[nodiscard]] std::size_t size() const { return mSlabs.size(); }
    [[nodiscard]] Leaves operator[](std::size_t slab) const;

    /// Call work(slab) for each slab in order. Every slab within `reach` leaves is passed to open() before; slabs out
    /// of reach of all later ones are passed to close(). In a periodic box the last slabs, in reach of the first, are
    /// opened before all others, and the first, in reach of the last, closed after all others.
    template<typename Open, typename Close, typename Work>
    void sweep(int reach, const Open& open, const Close& close, const Work& work) const
    {
        const auto [begin, end] = awayFromSeam(reach);
        for (std::size_t slab = end; slab < size(); ++slab)
            open(slab);
        std::size_t first = begin, last = 0;
        for (std::size_t slab = 0; slab < size(); ++slab) {
            for (; distance(first, slab) > reach; ++first)
                close(first);
            for (; last < end && distance(slab, last) <= reach; ++last)
                open(last);
            work(slab);
        }
        for (; first < size(); ++first)
            close(first);
        for (std::size_t slab = 0; slab < begin; ++slab)
            close(slab);
    }

    /// The slab before or after one; in a periodic box the first follows the last. Nothing where there is none.
    [[nodiscard]] std::optional<std::size_t> before(std::size_t slab) const
    {
        if (slab > 0) return slab - 1;
        return mPeriod > 0 ? std::optional(size() - 1) : std::nullopt;
    }
    [[nodiscard]] std::optional<std::size_t> after(std::size_t slab) const
    {
        if (slab + 1 < size()) return slab + 1;
        return mPeriod > 0 ? std::optional<std::size_t>(0) : std::nullopt;
    }

  private:
    struct Slab {
        int first, last;   ///< layers: coordinates along the axis, in leaves
        std::size_t begin; ///< index in mLeaves
    };

    /// Layers from one slab to a later one; 0 if `after` is not later.
    [[nodiscard]] int distance(std::size_t before, std::size_t after) const
    {
        return before < after ? mSlabs[after].first - mSlabs[before].last : 0;
    }

    /// The slabs from which no path crosses the seam of a periodic box: all if there is none.
    /// @return the first of them, and the one after the last
    [[nodiscard]] std::pair<std::size_t, std::size_t> awayFromSeam(int reach) const;

    void sortLeaves(const Domain& domain);
    void sortSlabs();

    int mAxis = 0;
    int mPeriod = 0; // layers of a periodic box; 0 if the axis has no period
    std::vector<std::uint32_t> mLeaves;
    std::vector<Slab> mSlabs;
};

} // namespace vdblic
