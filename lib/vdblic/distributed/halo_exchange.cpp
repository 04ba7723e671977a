#include "vdblic/distributed/halo_exchange.h"

#include "vdblic/core/message.h"

#include <cstddef>
#include <utility>

namespace vdblic {

HaloExchange::HaloExchange(Exchange& exchange, const Partition& partition, const Domain& domain,
                           std::vector<Rim<Space::kTexture>> depths)
    : mExchange(exchange), mPartition(partition), mDomain(domain), mDepths(std::move(depths)),
      mGiven(std::size_t(exchange.size())), mTaken(std::size_t(exchange.size()))
{
    const VoxelBox<Space::kTexture> mine = partition.textureBox(exchange.rank());
    for (int rank = 0; rank < exchange.size(); ++rank) {
        const VoxelBox<Space::kTexture> around = dilated(partition.textureBox(rank), mDepths[std::size_t(rank)]);
        if (rank == exchange.rank() || !domain.period().overlap(around.voxels, mine.voxels)) continue;
        for (const std::uint32_t leaf : domain.own()) {
            if (domain.period().isSeenIn(around.voxels, domain.origin(leaf))) mGiven[std::size_t(rank)].push_back(leaf);
        }
    }
    for (const std::uint32_t leaf : domain.local()) {
        if (!domain.isOwn(leaf)) mTaken[std::size_t(partition.owner({domain.origin(leaf)}))].push_back(leaf);
    }
}

void HaloExchange::addHits(const std::function<std::int64_t*(std::size_t leaf)>& hitsOf) const
{
    std::vector<Exchange::Bytes> messages(mTaken.size());
    std::vector<std::int64_t> words;
    for (std::size_t rank = 0; rank < mTaken.size(); ++rank) {
        for (const std::uint32_t leaf : mTaken[rank]) {
            words.clear();
            bool touched = false;
            const std::int64_t* const hits = hitsOf(leaf);
            for (auto voxel = mDomain.mask(leaf).beginOn(); voxel; ++voxel) {
                words.push_back(hits[voxel.pos()]);
                touched = touched || words.back() != 0;
            }
            put(messages[rank], touched);
            if (touched) put(messages[rank], words.data(), words.size());
        }
    }
    const std::vector<Exchange::Bytes> received = mExchange.swap(std::move(messages));
    for (std::size_t rank = 0; rank < mGiven.size(); ++rank) {
        MessageReader message(received[rank]);
        for (const std::uint32_t leaf : mGiven[rank]) {
            if (!message.get<bool>()) continue;
            words.resize(mDomain.mask(leaf).countOn());
            message.get(words.data(), words.size());
            auto word = words.begin();
            std::int64_t* const hits = hitsOf(leaf);
            for (auto voxel = mDomain.mask(leaf).beginOn(); voxel; ++voxel)
                hits[voxel.pos()] += *word++;
        }
    }
}

template<typename T>
void HaloExchange::takeValues(LeafValues<T>& values, int leaves) const
{
    using Depths = std::vector<Rim<Space::kTexture>>;
    const Depths near(mDepths.size(), {openvdb::Coord(leaves * LeafVoxel::kDim)});
    const Depths& depths = leaves == kWholeHalo ? mDepths : near;
    std::vector<Exchange::Bytes> messages(mGiven.size());
    std::vector<T> numbers;
    for (std::size_t rank = 0; rank < mGiven.size(); ++rank) {
        const VoxelBox<Space::kTexture> around = dilated(mPartition.textureBox(int(rank)), depths[rank]);
        for (const std::uint32_t leaf : mGiven[rank]) {
            if (!mDomain.period().isSeenIn(around.voxels, mDomain.origin(leaf))) continue;
            numbers.clear();
            for (auto voxel = mDomain.mask(leaf).beginOn(); voxel; ++voxel)
                numbers.push_back(values[leaf][voxel.pos()]);
            put(messages[rank], numbers.data(), numbers.size());
        }
    }
    const std::vector<Exchange::Bytes> received = mExchange.swap(std::move(messages));
    const VoxelBox<Space::kTexture> around =
        dilated(mPartition.textureBox(mExchange.rank()), depths[std::size_t(mExchange.rank())]);
    for (std::size_t rank = 0; rank < mTaken.size(); ++rank) {
        MessageReader message(received[rank]);
        for (const std::uint32_t leaf : mTaken[rank]) {
            if (!mDomain.period().isSeenIn(around.voxels, mDomain.origin(leaf))) continue;
            numbers.resize(mDomain.mask(leaf).countOn());
            message.get(numbers.data(), numbers.size());
            auto number = numbers.begin();
            for (auto voxel = mDomain.mask(leaf).beginOn(); voxel; ++voxel)
                values[leaf][voxel.pos()] = *number++;
        }
    }
}

void HaloExchange::takeHalo(LeafValues<float>& values, int leaves) const
{
    takeValues(values, leaves);
}

void HaloExchange::takeHalo(LeafValues<std::int32_t>& values, int leaves) const
{
    takeValues(values, leaves);
}

void HaloExchange::send(const Domain& domain, const std::function<void(std::size_t, Exchange::Bytes&)>& write,
                        const std::function<void(std::size_t, MessageReader&)>& read) const
{
    std::vector<Exchange::Bytes> messages(std::size_t(mExchange.size()));
    for (const std::uint32_t leaf : domain.local()) {
        if (domain.isOwn(leaf)) continue;
        Exchange::Bytes about;
        write(leaf, about);
        if (about.empty()) continue;
        Exchange::Bytes& message = messages[std::size_t(mPartition.owner({domain.origin(leaf)}))];
        put(message, leaf);
        message += about;
    }
    for (const Exchange::Bytes& bytes : mExchange.swap(std::move(messages))) {
        for (MessageReader message(bytes); !message.atEnd();) {
            const auto leaf = message.get<std::uint32_t>();
            read(leaf, message);
        }
    }
}

std::vector<Exchange::Bytes> HaloExchange::tell(const Exchange::Bytes& message) const
{
    return mExchange.swap(std::vector<Exchange::Bytes>(std::size_t(mExchange.size()), message));
}

} // namespace vdblic
