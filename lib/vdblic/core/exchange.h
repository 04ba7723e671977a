#pragma once

#include <cstdint>
#include <cstring>
#include <exception>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdblic {

/// Collective communication of the processes that share one run. Each is a *rank*, numbered from 0.
///
/// All functions but rank() and size() are collective: every rank calls them in the same order. If a rank fails
/// instead, it calls fail(), and the others' call throws the same error; so no rank waits for one that gave up. Not
/// thread-safe.
class Exchange {
  public:
    using Bytes = std::string;

    virtual ~Exchange() = default;
    [[nodiscard]] virtual int rank() const = 0;
    [[nodiscard]] virtual int size() const = 0;
    [[nodiscard]] bool isFirst() const { return rank() == 0; }
    [[nodiscard]] bool isAlone() const { return size() == 1; }

    /// Send a message to each rank and receive one from each. @param messages by rank
    [[nodiscard]] std::vector<Bytes> swap(std::vector<Bytes> messages);
    /// All ranks' messages at rank 0; at the others nothing.
    [[nodiscard]] std::vector<Bytes> gather(Bytes message);
    /// Rank 0's message at all ranks.
    [[nodiscard]] Bytes broadcast(Bytes message);
    /// Replace each number by its sum, or by its largest value, over all ranks.
    void sum(std::span<std::uint64_t> numbers);
    void max(std::span<double> numbers);
    /// Whether `here` is true at any rank.
    [[nodiscard]] bool any(bool here);
    /// The values of all ranks in rank order, at all ranks.
    template<typename T>
    [[nodiscard]] std::vector<T> join(const std::vector<T>& values)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        if (isAlone()) return values;
        Bytes all;
        for (const Bytes& message :
             gather(Bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T))))
            all += message;
        all = broadcast(std::move(all));
        std::vector<T> joined(all.size() / sizeof(T));
        if (!joined.empty()) std::memcpy(static_cast<void*>(joined.data()), all.data(), all.size());
        return joined;
    }
    /// Wait for all ranks.
    void agree();
    /// Run a job at all ranks. @throws at every rank if it fails at one
    template<typename Job>
    void together(const Job& job)
    {
        try {
            job();
            agree();
        } catch (...) {
            fail(std::current_exception());
            throw;
        }
    }

    /// Report this rank's failure to the others, in place of the collective call that they are in. Called once per
    /// error; ignores an error that a collective call threw, since all ranks have it.
    void fail(const std::exception_ptr& why) noexcept;

    /// Bytes sent by this rank in swap().
    [[nodiscard]] std::uint64_t sent() const { return mSent; }

  protected:
    virtual std::vector<Bytes> doSwap(std::vector<Bytes> messages) = 0;
    virtual std::vector<Bytes> doGather(Bytes message) = 0;
    /// @param from the sending rank
    virtual Bytes doBroadcast(Bytes message, int from) = 0;
    virtual void doSum(std::span<std::uint64_t> numbers) = 0;
    virtual void doMax(std::span<double> numbers) = 0;

  private:
    std::uint64_t mSent = 0;
    bool mWasTold = false; // the last error was another rank's
};

/// The exchange of a single process.
class OneProcess final : public Exchange {
  public:
    [[nodiscard]] int rank() const override { return 0; }
    [[nodiscard]] int size() const override { return 1; }

  protected:
    std::vector<Bytes> doSwap(std::vector<Bytes> messages) override { return messages; }
    std::vector<Bytes> doGather(Bytes message) override { return {std::move(message)}; }
    Bytes doBroadcast(Bytes message, int /*from*/) override { return message; }
    void doSum(std::span<std::uint64_t> /*numbers*/) override {}
    void doMax(std::span<double> /*numbers*/) override {}
};

} // namespace vdblic
