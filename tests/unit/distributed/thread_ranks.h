#pragma once

#include "vdblic/core/exchange.h"

#include <barrier>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>
#include <thread>
#include <utility>
#include <vector>

namespace vdblic::test {

/// Ranks that are threads of one process, for tests and sanitizers.
class ThreadRanks {
  public:
    explicit ThreadRanks(int size) : mSize(size), mBarrier(size), mMessages(std::size_t(size)) {}

    /// Call job(exchange) in a thread for each rank; rethrow the error of the first rank that threw.
    template<typename Job>
    void run(const Job& job)
    {
        std::vector<std::exception_ptr> errors(static_cast<std::size_t>(mSize));
        std::vector<std::thread> threads;
        threads.reserve(errors.size());
        for (int rank = 0; rank < mSize; ++rank) {
            threads.emplace_back([&, rank] {
                One exchange(*this, rank);
                try {
                    job(exchange);
                } catch (...) {
                    errors[std::size_t(rank)] = std::current_exception();
                    exchange.fail(errors[std::size_t(rank)]);
                }
            });
        }
        for (std::thread& thread : threads)
            thread.join();
        for (const std::exception_ptr& error : errors) {
            if (error) std::rethrow_exception(error);
        }
    }

  private:
    class One final : public Exchange {
      public:
        One(ThreadRanks& all, int rank) : mAll(all), mRank(rank) {}
        [[nodiscard]] int rank() const override { return mRank; }
        [[nodiscard]] int size() const override { return mAll.mSize; }

      protected:
        std::vector<Bytes> doSwap(std::vector<Bytes> messages) override
        {
            const auto all = share(std::move(messages));
            std::vector<Bytes> mine;
            mine.reserve(all.size());
            for (const std::vector<Bytes>& from : all)
                mine.push_back(from[std::size_t(mRank)]);
            return mine;
        }
        std::vector<Bytes> doGather(Bytes message) override
        {
            std::vector<Bytes> messages;
            for (const std::vector<Bytes>& from : share({std::move(message)}))
                messages.push_back(from.front());
            return mRank == 0 ? messages : std::vector<Bytes>();
        }
        Bytes doBroadcast(Bytes message, int from) override
        {
            return share({std::move(message)})[std::size_t(from)][0];
        }
        void doSum(std::span<std::uint64_t> numbers) override
        {
            combine(numbers, [](std::uint64_t a, std::uint64_t b) { return a + b; });
        }
        void doMax(std::span<double> numbers) override
        {
            combine(numbers, [](double a, double b) { return a < b ? b : a; });
        }

      private:
        /// Everyone's messages.
        std::vector<std::vector<Bytes>> share(std::vector<Bytes> messages)
        {
            mAll.mMessages[std::size_t(mRank)] = std::move(messages);
            mAll.mBarrier.arrive_and_wait();
            std::vector<std::vector<Bytes>> all = mAll.mMessages;
            mAll.mBarrier.arrive_and_wait();
            return all;
        }
        template<typename T, typename Operation>
        void combine(std::span<T> numbers, const Operation& operation)
        {
            const Bytes mine(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes());
            const auto all = share({mine});
            for (std::size_t i = 0; i < numbers.size(); ++i) {
                for (std::size_t rank = 0; rank < all.size(); ++rank) {
                    const T number = reinterpret_cast<const T*>(all[rank].front().data())[i];
                    numbers[i] = rank == 0 ? number : operation(numbers[i], number);
                }
            }
        }

        ThreadRanks& mAll;
        int mRank;
    };

    int mSize;
    std::barrier<> mBarrier;
    std::vector<std::vector<Exchange::Bytes>> mMessages; // of each rank
};

} // namespace vdblic::test
