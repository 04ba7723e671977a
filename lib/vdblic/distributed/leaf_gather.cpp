#include "vdblic/distributed/leaf_gather.h"

#include "vdblic/distributed/message.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using FloatLeaf = openvdb::FloatTree::LeafNodeType;

Exchange::Bytes leafMessage(const StoredLeaves& leaves, Domain::Leaves numbers)
{
    Exchange::Bytes message;
    put(message, std::uint64_t(numbers.size()));
    put(message, std::uint64_t(leaves.sizes.size()));
    put(message, numbers.data(), numbers.size());
    put(message, leaves.lengths.data(), leaves.lengths.size());
    put(message, leaves.kinds.data(), leaves.kinds.size());
    put(message, leaves.sizes.data(), leaves.sizes.size());
    for (const std::string& block : leaves.blocks)
        message += block;
    return message;
}

/// The leaves of one rank, and where their records are in its message.
struct Received {
    std::vector<std::uint32_t> numbers, lengths;
    std::vector<signed char> kinds;
    std::vector<std::int64_t> sizes;
    std::size_t records; // where they begin

    explicit Received(const Exchange::Bytes& bytes)
    {
        MessageReader message(bytes);
        const auto count = message.get<std::uint64_t>(), sizeCount = message.get<std::uint64_t>();
        numbers.resize(count);
        lengths.resize(count);
        kinds.resize(count);
        sizes.resize(sizeCount);
        message.get(numbers.data(), count);
        message.get(lengths.data(), count);
        message.get(kinds.data(), count);
        message.get(sizes.data(), sizeCount);
        records = bytes.size() - std::accumulate(lengths.begin(), lengths.end(), std::size_t(0));
    }
};

} // namespace

StoredLeaves gatherLeaves(Exchange& exchange, const Domain& domain, const openvdb::FloatGrid& grid,
                          VdbCompression compression)
{
    std::vector<const FloatLeaf*> own;
    own.reserve(domain.own().size());
    for (const std::uint32_t leaf : domain.own())
        own.push_back(grid.constTree().probeConstLeaf(domain.origin(leaf)));
    std::vector<Exchange::Bytes> messages =
        exchange.gather(leafMessage(storeLeaves(grid, own, compression), domain.own()));
    StoredLeaves all;
    if (!exchange.isFirst()) return all;
    all.lengths.resize(domain.leafCount());
    all.kinds.resize(domain.leafCount());
    std::vector<const char*> records(domain.leafCount(), nullptr);
    for (const Exchange::Bytes& message : messages) {
        const Received part(message);
        if (!part.sizes.empty()) all.sizes.resize(domain.leafCount());
        std::size_t at = part.records;
        for (std::size_t i = 0; i < part.numbers.size(); ++i) {
            const std::size_t leaf = part.numbers[i];
            records[leaf] = message.data() + at;
            at += part.lengths[i];
            all.lengths[leaf] = part.lengths[i];
            all.kinds[leaf] = part.kinds[i];
            if (!part.sizes.empty()) all.sizes[leaf] = part.sizes[i];
        }
    }
    std::string& block = all.blocks.emplace_back();
    block.reserve(std::accumulate(all.lengths.begin(), all.lengths.end(), std::size_t(0)));
    for (std::size_t leaf = 0; leaf < records.size(); ++leaf)
        block.append(records[leaf], all.lengths[leaf]);
    return all;
}

openvdb::FloatGrid::Ptr withoutValues(const Domain& domain, const openvdb::FloatGrid& grid)
{
    auto tree = std::make_shared<openvdb::FloatTree>(grid.background());
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf) {
        auto node = std::make_unique<FloatLeaf>(openvdb::PartialCreate(), domain.origin(leaf), grid.background());
        node->setValueMask(domain.mask(leaf));
        tree->addLeaf(node.release()); // takes it over
    }
    auto result = openvdb::FloatGrid::create(tree);
    result->insertMeta(grid);
    result->setTransform(grid.transform().copy());
    result->setSaveFloatAsHalf(grid.saveFloatAsHalf());
    return result;
}

} // namespace vdblic
