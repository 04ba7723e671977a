#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/refinement.h"

#include <cstddef>
#include <cstdint>
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
    /// of reach of all later ones are passed to close().
    template<typename Open, typename Close, typename Work>
    void sweep(int reach, const Open& open, const Close& close, const Work& work) const
    {
        std::size_t first = 0, last = 0;
        for (std::size_t slab = 0; slab < size(); ++slab) {
            for (; distance(first, slab) > reach; ++first)
                close(first);
            for (; last < size() && distance(slab, last) <= reach; ++last)
                open(last);
            work(slab);
        }
        for (; first < last; ++first)
            close(first);
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

    void sortLeaves(const Domain& domain);
    void sortSlabs();

    int mAxis = 0;
    std::vector<std::uint32_t> mLeaves;
    std::vector<Slab> mSlabs;
};

} // namespace vdblic
