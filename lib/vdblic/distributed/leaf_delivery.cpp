#include "vdblic/distributed/leaf_delivery.h"

#include "vdblic/core/message.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace vdblic {
namespace {

using DeliveredGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::Int32Grid>;

constexpr std::size_t kLeavesPerChunk = std::size_t(1) << 13; // about 8 MB

/// The numbers, lengths, kinds and sizes of a rank's leaves, which the writer needs before the records.
Exchange::Bytes listOf(const OwnLeaves& leaves)
{
    Exchange::Bytes message;
    put(message, std::uint64_t(leaves.numbers.size()));
    put(message, std::uint64_t(leaves.stored.sizes.size()));
    put(message, leaves.numbers.data(), leaves.numbers.size());
    put(message, leaves.stored.lengths.data(), leaves.stored.lengths.size());
    put(message, leaves.stored.kinds.data(), leaves.stored.kinds.size());
    put(message, leaves.stored.sizes.data(), leaves.stored.sizes.size());
    return message;
}

/// Reads the records of a rank's own leaves in order, and frees them.
class RecordReader {
  public:
    explicit RecordReader(OwnLeaves leaves) : mLeaves(std::move(leaves)) {}

    [[nodiscard]] std::size_t all() const { return mLeaves.all; }

    /// The records of the next leaves. @param end number of the first leaf after them
    Exchange::Bytes takeUpTo(std::size_t end)
    {
        const auto numbers = mLeaves.numbers.begin();
        const auto last = std::lower_bound(numbers + std::ptrdiff_t(mLeaf), mLeaves.numbers.end(), end) - numbers;
        const auto lengths = mLeaves.stored.lengths.begin();
        Exchange::Bytes records;
        records.reserve(std::accumulate(lengths + std::ptrdiff_t(mLeaf), lengths + last, std::size_t(0)));
        for (; mLeaf < std::size_t(last); ++mLeaf) {
            std::string& block = mLeaves.stored.blocks[mBlock];
            const std::uint32_t length = mLeaves.stored.lengths[mLeaf];
            records.append(block, mAt, length);
            mAt += length;
            if (mAt < block.size()) continue;
            block = {};
            ++mBlock;
            mAt = 0;
        }
        return records;
    }

  private:
    OwnLeaves mLeaves;
    std::size_t mLeaf = 0, mBlock = 0, mAt = 0; // mAt in the block
};

/// Merges the leaves of one grid from all ranks in the grid's order.
class ChunkWriter {
  public:
    /// @param lists of all ranks  @param all number of the grid's leaves
    ChunkWriter(const std::vector<Exchange::Bytes>& lists, std::size_t all, LeafStream& stream)
        : mStream(stream), mLengths(all), mOwners(all)
    {
        StoredLeaves leaves;
        leaves.lengths.resize(all);
        leaves.kinds.resize(all);
        for (std::size_t rank = 0; rank < lists.size(); ++rank) {
            MessageReader message(lists[rank]);
            std::vector<std::uint32_t> numbers(message.get<std::uint64_t>()), lengths(numbers.size());
            std::vector<signed char> kinds(numbers.size());
            std::vector<std::int64_t> sizes(message.get<std::uint64_t>());
            message.get(numbers.data(), numbers.size());
            message.get(lengths.data(), lengths.size());
            message.get(kinds.data(), kinds.size());
            message.get(sizes.data(), sizes.size());
            if (!sizes.empty()) leaves.sizes.resize(all);
            for (std::size_t i = 0; i < numbers.size(); ++i) {
                const std::size_t leaf = numbers[i];
                leaves.lengths[leaf] = lengths[i];
                leaves.kinds[leaf] = kinds[i];
                if (!sizes.empty()) leaves.sizes[leaf] = sizes[i];
                mOwners[leaf] = std::uint32_t(rank);
            }
        }
        mLengths = leaves.lengths;
        mStream.begin(std::move(leaves));
    }

    /// @param records of the next chunk's leaves, by rank
    void write(const std::vector<Exchange::Bytes>& records)
    {
        const std::size_t end = std::min(mLeaf + kLeavesPerChunk, mLengths.size());
        std::vector<std::size_t> at(records.size());
        std::string block;
        block.reserve(std::accumulate(records.begin(), records.end(), std::size_t(0),
                                      [](std::size_t sum, const auto& bytes) { return sum + bytes.size(); }));
        for (; mLeaf < end; ++mLeaf) {
            const std::size_t rank = mOwners[mLeaf];
            block.append(records[rank], at[rank], mLengths[mLeaf]);
            at[rank] += mLengths[mLeaf];
        }
        mStream.give(std::move(block));
    }

  private:
    LeafStream& mStream;
    std::vector<std::uint32_t> mLengths, mOwners; // of each leaf; its owner
    std::size_t mLeaf = 0;
};

} // namespace

OwnLeaves storeOwn(const Domain& domain, const openvdb::GridBase& grid, VdbCompression compression)
{
    OwnLeaves leaves{domain.leafCount(), {domain.own().begin(), domain.own().end()}, {}};
    grid.apply<DeliveredGrids>([&](const auto& typed) {
        using GridT = std::decay_t<decltype(typed)>;
        std::vector<const typename GridT::TreeType::LeafNodeType*> own;
        own.reserve(domain.own().size());
        for (const std::uint32_t leaf : domain.own())
            own.push_back(typed.constTree().probeConstLeaf(domain.origin(leaf)));
        leaves.stored = storeLeaves(typed, own, compression);
    });
    return leaves;
}

void deliver(Exchange& exchange, std::vector<OwnLeaves> grids, LeafStream* stream)
{
    if (exchange.isAlone()) { // all leaves are here, in file order
        stream->begin(std::move(grids.front().stored));
        return stream->end();
    }
    std::vector<Exchange::Bytes> messages(std::size_t(exchange.size()));
    std::vector<RecordReader> readers;
    std::size_t most = 0; // leaves of a grid
    for (OwnLeaves& grid : grids) {
        messages[readers.size()] = listOf(grid);
        most = std::max(most, grid.all);
        readers.emplace_back(std::move(grid));
    }
    const std::vector<Exchange::Bytes> lists = exchange.swap(std::move(messages));
    std::optional<ChunkWriter> writer;
    if (stream) writer.emplace(lists, readers[std::size_t(exchange.rank())].all(), *stream);
    for (std::size_t chunk = 0; chunk * kLeavesPerChunk < most; ++chunk) {
        messages = std::vector<Exchange::Bytes>(std::size_t(exchange.size()));
        for (std::size_t rank = 0; rank < readers.size(); ++rank)
            messages[rank] = readers[rank].takeUpTo((chunk + 1) * kLeavesPerChunk);
        const std::vector<Exchange::Bytes> records = exchange.swap(std::move(messages));
        if (writer) writer->write(records);
    }
    if (stream) stream->end();
}

openvdb::GridBase::Ptr gathered(Exchange& exchange, const Domain& domain, const openvdb::GridBase& grid)
{
    openvdb::GridBase::Ptr result = exchange.isFirst() ? grid.copyGridWithNewTree() : nullptr;
    grid.apply<DeliveredGrids>([&](const auto& typed) {
        using GridT = std::decay_t<decltype(typed)>;
        using Leaf = typename GridT::TreeType::LeafNodeType;
        Exchange::Bytes values;
        for (const std::uint32_t leaf : domain.own()) {
            put(values, leaf);
            put(values, typed.constTree().probeConstLeaf(domain.origin(leaf))->buffer().data(), Leaf::SIZE);
        }
        for (const Exchange::Bytes& part : exchange.gather(std::move(values))) {
            for (MessageReader message(part); !message.atEnd();) {
                const auto number = message.get<std::uint32_t>();
                auto leaf = std::make_unique<Leaf>(domain.origin(number), typed.background());
                message.get(leaf->buffer().data(), Leaf::SIZE);
                leaf->setValueMask(domain.mask(number));
                static_cast<GridT&>(*result).tree().addLeaf(leaf.release()); // takes ownership
            }
        }
    });
    return result;
}

openvdb::GridBase::Ptr withoutValues(const Domain& domain, const openvdb::GridBase& grid)
{
    openvdb::GridBase::Ptr result = grid.copyGridWithNewTree();
    result->apply<DeliveredGrids>([&](auto& typed) {
        using Leaf = typename std::decay_t<decltype(typed)>::TreeType::LeafNodeType;
        for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
            auto node = std::make_unique<Leaf>(openvdb::PartialCreate(), domain.origin(leaf), typed.background());
            node->setValueMask(domain.mask(leaf));
            typed.tree().addLeaf(node.release()); // takes ownership
        }
    });
    return result;
}

} // namespace vdblic
