#include "vdblic/mpi/mpi_exchange.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mpi.h>
#include <utility>

namespace vdblic {
namespace {

constexpr std::size_t kMostBytes = std::size_t(64) << 20; // of one message: MPI counts with an int

/// Call part(offset, bytes) for each part of a long message.
template<typename Part>
void inParts(std::size_t bytes, const Part& part)
{
    for (std::size_t at = 0; at < bytes; at += kMostBytes)
        part(at, int(std::min(kMostBytes, bytes - at)));
}

} // namespace

MpiExchange::MpiExchange(int& argc, char**& argv)
{
    int provided = 0; // one thread of each process calls MPI
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &mRank);
    MPI_Comm_size(MPI_COMM_WORLD, &mSize);
    MPI_Comm host = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, mRank, MPI_INFO_NULL, &host);
    MPI_Comm_size(host, &mOnHost);
    MPI_Comm_free(&host);
}

MpiExchange::~MpiExchange()
{
    MPI_Finalize();
}

std::vector<Exchange::Bytes> MpiExchange::doSwap(std::vector<Bytes> messages)
{
    const auto ranks = std::size_t(mSize);
    std::vector<std::uint64_t> given(ranks), taken(ranks);
    for (std::size_t rank = 0; rank < ranks; ++rank)
        given[rank] = messages[rank].size();
    MPI_Alltoall(given.data(), 1, MPI_UINT64_T, taken.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD);
    std::vector<Bytes> received(ranks);
    std::vector<MPI_Request> requests;
    for (int other = 0; other < mSize; ++other) {
        if (other == mRank) continue;
        Bytes& message = received[std::size_t(other)];
        message.resize(taken[std::size_t(other)]);
        inParts(message.size(), [&](std::size_t at, int bytes) {
            MPI_Irecv(message.data() + at, bytes, MPI_BYTE, other, 0, MPI_COMM_WORLD, &requests.emplace_back());
        });
    }
    for (int distance = 1; distance < mSize; ++distance) { // not all to rank 0 first
        const int other = (mRank + distance) % mSize;
        const Bytes& message = messages[std::size_t(other)];
        inParts(message.size(), [&](std::size_t at, int bytes) {
            MPI_Isend(message.data() + at, bytes, MPI_BYTE, other, 0, MPI_COMM_WORLD, &requests.emplace_back());
        });
    }
    MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    received[std::size_t(mRank)] = std::move(messages[std::size_t(mRank)]);
    return received;
}

std::vector<Exchange::Bytes> MpiExchange::doGather(Bytes message)
{
    std::vector<Bytes> messages(static_cast<std::size_t>(mSize));
    messages.front() = std::move(message);
    messages = doSwap(std::move(messages));
    return mRank == 0 ? messages : std::vector<Bytes>();
}

Exchange::Bytes MpiExchange::doBroadcast(Bytes message, int from)
{
    std::uint64_t size = message.size();
    MPI_Bcast(&size, 1, MPI_UINT64_T, from, MPI_COMM_WORLD);
    message.resize(size);
    inParts(size,
            [&](std::size_t at, int bytes) { MPI_Bcast(message.data() + at, bytes, MPI_BYTE, from, MPI_COMM_WORLD); });
    return message;
}

void MpiExchange::doSum(std::span<std::uint64_t> numbers)
{
    MPI_Allreduce(MPI_IN_PLACE, numbers.data(), int(numbers.size()), MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
}

void MpiExchange::doMax(std::span<double> numbers)
{
    MPI_Allreduce(MPI_IN_PLACE, numbers.data(), int(numbers.size()), MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
}

} // namespace vdblic
