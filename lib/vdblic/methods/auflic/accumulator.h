#pragma once

#include "vdblic/field/domain.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// What the pathlines of a step scatter into: an OpenVDB Int64 tree whose voxels are Hits words, and a table of
/// pointers to its leaves' values, by the domain's numbers.
///
/// The tree has the open leaves of a domain only: they are added before a path can lead to them, and stolen from it as
/// soon as no path leads there any more. Exactly the domain's voxels are active; everywhere else, in leaves and outside
/// them, the value is Hits::kOutside.
///
/// Any number of threads may read the pointers, and add to the words atomically; leaves are opened and closed by one
/// thread.
class Accumulator {
  public:
    explicit Accumulator(const Domain& domain); ///< All leaves are closed. @param domain must outlive this

    /// Open leaves, with words without a hit. In parallel.
    void open(Domain::Leaves leaves);
    void close(Domain::Leaves leaves);

    /// The 512 words of a leaf, x slowest; null if it is closed.
    [[nodiscard]] std::int64_t* operator[](std::size_t leaf) { return mWords[leaf]; }
    [[nodiscard]] const std::int64_t* operator[](std::size_t leaf) const { return mWords[leaf]; }
    [[nodiscard]] const openvdb::Int64Tree& tree() const { return *mTree; }

  private:
    const Domain& mDomain;
    openvdb::Int64Tree::Ptr mTree;
    std::vector<std::int64_t*> mWords; // of the tree's leaves
};

} // namespace vdblic
