#pragma once

#include "vdblic/field/domain.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// The target of a step's scattering: an OpenVDB Int64 tree of Hits words, and a table of pointers to its leaves'
/// values, by the domain's numbers.
///
/// The tree has only the domain's open leaves: they are added before a path can reach them, and removed once no path
/// can reach them any more. Exactly the domain's voxels are active; all other voxels are Hits::kOutside.
///
/// Any number of threads may read the pointers and add to the words atomically; one thread opens and closes leaves.
class Accumulator {
  public:
    explicit Accumulator(const Domain& domain); ///< All leaves are closed. @param domain must outlive this

    /// Open leaves, in parallel; their words have no hits.
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
