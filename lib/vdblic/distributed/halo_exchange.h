#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/partition.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_owners.h"
#include "vdblic/field/units.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace vdblic {

/// A rank's halo (the leaves around its own ones), and its own leaves in the halos of other ranks. Both sides of an
/// exchange list the same leaves in the same order: messages hold values only.
class HaloExchange final : public LeafOwners {
  public:
    /// @param domain with this rank's own leaves and, as local ones, its halo; must outlive this, like exchange and
    /// partition
    /// @param depths of each rank's halo, whole leaves
    HaloExchange(Exchange& exchange, const Partition& partition, const Domain& domain,
                 std::vector<Rim<Space::kTexture>> depths);

    [[nodiscard]] bool areSeveral() const override { return true; }
    void addHits(const std::function<std::int64_t*(std::size_t leaf)>& hitsOf) const override;
    void takeHalo(LeafValues<float>& values, int leaves) const override;
    void takeHalo(LeafValues<std::int32_t>& values, int leaves) const override;
    void send(const Domain& domain, const std::function<void(std::size_t leaf, Exchange::Bytes&)>& write,
              const std::function<void(std::size_t leaf, MessageReader&)>& read) const override;
    [[nodiscard]] std::vector<Exchange::Bytes> tell(const Exchange::Bytes& message) const override;
    void sum(std::span<std::uint64_t> numbers) const override { mExchange.sum(numbers); }

  private:
    template<typename T>
    void takeValues(LeafValues<T>& values, int leaves) const;

    Exchange& mExchange;
    const Partition& mPartition;
    const Domain& mDomain;
    std::vector<Rim<Space::kTexture>> mDepths;              // of each rank's halo
    std::vector<std::vector<std::uint32_t>> mGiven, mTaken; // leaves, by rank
};

} // namespace vdblic
