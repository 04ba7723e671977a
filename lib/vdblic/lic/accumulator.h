#pragma once

#include "vdblic/field/domain.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdblic {

/// The hits of a step: a Hits word for each voxel of the open leaves of a domain. The others take no memory.
///
/// Any number of threads may read; leaves are opened and closed by one thread.
class Accumulator {
  public:
    explicit Accumulator(const Domain& domain); ///< All leaves are closed. @param domain must outlive this

    /// Open leaves: words without a hit, Hits::kOutside where the domain has no voxel. In parallel.
    void open(Domain::Leaves leaves);
    void close(Domain::Leaves leaves);

    /// The 512 words of a leaf, x slowest; null if it is closed.
    [[nodiscard]] std::int64_t* operator[](std::size_t leaf) const { return mLeaves[leaf].get(); }

  private:
    const Domain& mDomain;
    std::vector<std::unique_ptr<std::int64_t[]>> mLeaves;
};

} // namespace vdblic
