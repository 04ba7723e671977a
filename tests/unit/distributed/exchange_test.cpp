#include "vdblic/core/exchange.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/reporter.h"

#include "distributed/thread_ranks.h"
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <new>
#include <string>
#include <vector>

namespace vdblic {
namespace {

TEST(Exchange, BringsEveryMessageToItsRank)
{
    test::ThreadRanks(4).run([](Exchange& exchange) {
        std::vector<Exchange::Bytes> messages;
        for (int to = 0; to < 4; ++to)
            messages.push_back(std::to_string(exchange.rank()) + " to " + std::to_string(to));
        const std::vector<Exchange::Bytes> received = exchange.swap(messages);
        for (int from = 0; from < 4; ++from)
            EXPECT_EQ(received[std::size_t(from)], std::to_string(from) + " to " + std::to_string(exchange.rank()));
        const std::vector<Exchange::Bytes> all = exchange.gather(std::string(1, char('a' + exchange.rank())));
        EXPECT_EQ(all, exchange.isFirst() ? std::vector<Exchange::Bytes>({"a", "b", "c", "d"})
                                          : std::vector<Exchange::Bytes>());
        EXPECT_EQ(exchange.broadcast(exchange.isFirst() ? "one" : "another"), "one");
        std::array<std::uint64_t, 2> sums = {1, std::uint64_t(exchange.rank())};
        exchange.sum(sums);
        EXPECT_EQ(sums, (std::array<std::uint64_t, 2>{4, 6}));
        std::array<double, 2> most = {double(exchange.rank()), -double(exchange.rank())};
        exchange.max(most);
        EXPECT_EQ(most, (std::array<double, 2>{3, 0}));
        EXPECT_TRUE(exchange.any(exchange.rank() == 2));
        EXPECT_FALSE(exchange.any(false));
    });
}

TEST(Exchange, JoinsTheValuesOfAllRanksInTheirOrder)
{
    test::ThreadRanks(4).run([](Exchange& exchange) {
        const std::vector<int> mine(std::size_t(exchange.rank() % 3),
                                    exchange.rank()); // the first and the last have none
        EXPECT_EQ(exchange.join(mine), (std::vector<int>{1, 2, 2}));
    });
    OneProcess alone;
    EXPECT_EQ(alone.join(std::vector<int>{4, 5}), (std::vector<int>{4, 5}));
}

TEST(Exchange, AJobThatFailsAtOneRankFailsAtAll)
{
    std::atomic<int> failed = 0, done = 0;
    test::ThreadRanks(3).run([&](Exchange& exchange) {
        for (int job = 0; job < 3; ++job) {
            try {
                exchange.together([&] {
                    if (exchange.rank() == job) throw InputError("damaged");
                    ++done;
                });
            } catch (const InputError&) {
                ++failed;
            }
        }
        exchange.together([&] { EXPECT_TRUE(exchange.any(exchange.rank() == 2)); });
    });
    EXPECT_EQ(failed, 9);
    EXPECT_EQ(done, 6);
}

/// What all ranks throw if some of them throw `error` while the others wait for them.
template<typename Error, typename Thrown>
int ranksThatThrow(const Thrown& error, const std::vector<int>& failing)
{
    std::atomic<int> thrown = 0;
    test::ThreadRanks(5).run([&](Exchange& exchange) {
        try {
            exchange.agree();
            for (const int rank : failing) {
                if (rank == exchange.rank()) throw error;
            }
            (void)exchange.swap(std::vector<Exchange::Bytes>(5));
        } catch (const Error&) {
            exchange.fail(std::current_exception());
            ++thrown;
            exchange.agree(); // the ranks can go on
        }
    });
    return thrown;
}

TEST(Exchange, GivesTheErrorOfOneRankToAll)
{
    EXPECT_EQ(ranksThatThrow<InputError>(InputError("damaged"), {3}), 5);
    EXPECT_EQ(ranksThatThrow<OutputError>(OutputError("full"), {0}), 5);
    EXPECT_EQ(ranksThatThrow<ParameterError>(ParameterError("wrong"), {1, 2, 4}), 5);
    EXPECT_EQ(ranksThatThrow<Stopped>(Stopped{}, {0, 1, 2, 3, 4}), 5);
    EXPECT_EQ(ranksThatThrow<std::bad_alloc>(std::bad_alloc(), {4}), 5);
    std::string message;
    try {
        test::ThreadRanks(3).run([](Exchange& exchange) {
            if (exchange.rank() > 0) throw InputError("rank " + std::to_string(exchange.rank()));
            exchange.agree();
        });
    } catch (const InputError& error) {
        message = error.what();
    }
    EXPECT_EQ(message, "rank 1"); // of the first of those that failed, told to rank 0
}

} // namespace
} // namespace vdblic
