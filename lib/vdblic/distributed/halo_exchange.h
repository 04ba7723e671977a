#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/partition.h"
#include "vdblic/field/domain.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace vdblic {

/// The leaves around a rank's own ones, its halo, and those of its own that lie in the halos of others. Both sides of
/// an exchange list the same leaves in the same order, so messages hold values only.
class HaloExchange {
  public:
    /// @param domain with this rank's own leaves, and as local ones those in its halo; must outlive this, like exchange
    ///               and partition
    /// @param depths of each rank's halo [texture voxels], whole leaves
    HaloExchange(Exchange& exchange, const Partition& partition, const Domain& domain,
                 std::vector<openvdb::Coord> depths);

    [[nodiscard]] Exchange& exchange() const { return mExchange; }
    [[nodiscard]] const Partition& partition() const { return mPartition; }

    /// Add the hits in the halo to those of the leaves' owners. Collective.
    /// @param hitsOf gives the Hits words of a local leaf
    void addToOwners(const std::function<std::int64_t*(std::size_t leaf)>& hitsOf) const;

    /// Take the values in the halo from the leaves' owners. Collective.
    /// @param leaves up to how far from the own ones
    void takeFromOwners(const LeafValues<float>& values, int leaves) const;
    void takeFromOwners(const LeafValues<float>& values) const;

  private:
    void take(const LeafValues<float>& values, const std::vector<openvdb::Coord>& depths) const;

    Exchange& mExchange;
    const Partition& mPartition;
    const Domain& mDomain;
    std::vector<openvdb::Coord> mDepths;                    // of each rank's halo
    std::vector<std::vector<std::uint32_t>> mGiven, mTaken; // leaves, by rank
};

} // namespace vdblic
