#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/message.h"
#include "vdblic/field/domain.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace vdblic {

/// The ranks that own the leaves of a domain, as one of them sees them in a step. Local leaves that are not own, the
/// *halo*, belong to others. SoleOwner is a process alone.
///
/// All functions but areSeveral() are collective.
class LeafOwners {
  public:
    virtual ~LeafOwners() = default;

    [[nodiscard]] virtual bool areSeveral() const = 0;

    /// Add the hits in the halo to the owners' leaves.
    /// @param hitsOf returns the Hits words of a local leaf
    virtual void addHits(const std::function<std::int64_t*(std::size_t leaf)>& hitsOf) const = 0;

    /// Receive the values in the halo from their owners.
    /// @param leaves depth of the halo to receive [leaves]
    virtual void takeHalo(LeafValues<float>& values, int leaves = kWholeHalo) const = 0;
    virtual void takeHalo(LeafValues<std::int32_t>& values, int leaves = kWholeHalo) const = 0;
    static constexpr int kWholeHalo = -1;

    /// Send a message about each leaf of a domain's halo to the leaf's owner.
    /// @param domain of this step or the next: its own leaves are this rank's
    /// @param write  appends to the message about a leaf; empty messages are not sent
    /// @param read   receives the message about an own leaf
    virtual void send(const Domain& domain, const std::function<void(std::size_t leaf, Exchange::Bytes&)>& write,
                      const std::function<void(std::size_t leaf, MessageReader&)>& read) const = 0;

    /// Send a message to all ranks. @return the messages of all ranks, by rank
    [[nodiscard]] virtual std::vector<Exchange::Bytes> tell(const Exchange::Bytes& message) const = 0;

    /// Replace each number by its sum over all ranks.
    virtual void sum(std::span<std::uint64_t> numbers) const = 0;
};

/// A process alone owns all leaves.
class SoleOwner final : public LeafOwners {
  public:
    [[nodiscard]] bool areSeveral() const override { return false; }
    void addHits(const std::function<std::int64_t*(std::size_t)>& /*hitsOf*/) const override {}
    void takeHalo(LeafValues<float>& /*values*/, int /*leaves*/) const override {}
    void takeHalo(LeafValues<std::int32_t>& /*values*/, int /*leaves*/) const override {}
    void send(const Domain& /*domain*/, const std::function<void(std::size_t, Exchange::Bytes&)>& /*write*/,
              const std::function<void(std::size_t, MessageReader&)>& /*read*/) const override
    {
    }
    [[nodiscard]] std::vector<Exchange::Bytes> tell(const Exchange::Bytes& message) const override { return {message}; }
    void sum(std::span<std::uint64_t> /*numbers*/) const override {}
};
inline const SoleOwner kSoleOwner;

} // namespace vdblic
