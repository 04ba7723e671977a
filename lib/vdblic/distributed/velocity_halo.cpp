#include "vdblic/distributed/velocity_halo.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/message.h"
#include "vdblic/field/domain.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3f;
using openvdb::Vec3STree;
using VelocityLeaf = Vec3STree::LeafNodeType;

/// Visit the active parts of a box: onLeaf(leaf), and onTile(origin, value) for each leaf-sized part of a tile.
template<typename OnLeaf, typename OnTile>
void visit(const Vec3STree& tree, const CoordBBox& box, const OnLeaf& onLeaf, const OnTile& onTile)
{
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
        if (box.isInside(leaf->origin()) && !leaf->isEmpty()) onLeaf(*leaf);
    }
    auto tile = tree.cbeginValueOn();
    tile.setMaxDepth(tile.getLeafDepth() - 1);
    for (; tile; ++tile) {
        CoordBBox part = tile.getBoundingBox();
        part.intersect(box);
        for (int x = part.min()[0]; x <= part.max()[0]; x += LeafVoxel::kDim) {
            for (int y = part.min()[1]; y <= part.max()[1]; y += LeafVoxel::kDim) {
                for (int z = part.min()[2]; z <= part.max()[2]; z += LeafVoxel::kDim)
                    onTile(Coord(x, y, z), *tile);
            }
        }
    }
}

constexpr int kTileLevel = 1; // leaf-sized tiles

using MaskWords = std::array<std::uint64_t, LeafVoxel::kCount / 64>;

MaskWords wordsOf(const VelocityLeaf::NodeMaskType& mask)
{
    MaskWords words;
    for (std::size_t i = 0; i < words.size(); ++i)
        words[i] = mask.getWord<std::uint64_t>(openvdb::Index(i));
    return words;
}

VelocityLeaf::NodeMaskType maskOfWords(const MaskWords& words)
{
    VelocityLeaf::NodeMaskType mask;
    for (std::size_t i = 0; i < words.size(); ++i)
        mask.getWord<std::uint64_t>(openvdb::Index(i)) = words[i];
    return mask;
}

/// The active voxels of a box, as a message.
Exchange::Bytes velocityMessage(const Vec3STree& tree, const CoordBBox& box)
{
    Exchange::Bytes message;
    std::vector<Vec3f> values;
    visit(
        tree, box,
        [&](const VelocityLeaf& leaf) {
            put(message, leaf.origin());
            put(message, wordsOf(leaf.getValueMask()));
            values.clear();
            for (auto value = leaf.cbeginValueOn(); value; ++value)
                values.push_back(*value);
            put(message, values.data(), values.size());
        },
        [&](const Coord& origin, const Vec3f& value) {
            put(message, origin);
            put(message, MaskWords{}); // no leaf has an empty mask
            put(message, value);
        });
    return message;
}

void readInto(Vec3STree& result, const Exchange::Bytes& bytes)
{
    std::vector<Vec3f> values;
    for (MessageReader message(bytes); !message.atEnd();) {
        const auto origin = message.get<Coord>();
        const VelocityLeaf::NodeMaskType mask = maskOfWords(message.get<MaskWords>());
        if (mask.isOff()) {
            result.addTile(kTileLevel, origin, message.get<Vec3f>(), true);
            continue;
        }
        values.resize(mask.countOn());
        message.get(values.data(), values.size());
        VelocityLeaf& leaf = *result.touchLeaf(origin); // may have other voxels
        auto value = values.begin();
        for (auto voxel = mask.beginOn(); voxel; ++voxel)
            leaf.setValueOn(voxel.pos(), *value++);
    }
}

} // namespace

Vec3STree::Ptr takenOut(Vec3STree& tree, const VoxelBox<Space::kVelocity>& box)
{
    auto result = std::make_shared<Vec3STree>(tree.background());
    std::vector<Coord> origins;
    visit(
        tree, box.voxels, [&](const VelocityLeaf& leaf) { origins.push_back(leaf.origin()); },
        [&](const Coord& origin, const Vec3f& value) { result->addTile(kTileLevel, origin, value, true); });
    for (const Coord& origin : origins)
        result->addLeaf(tree.stealNode<VelocityLeaf>(origin, tree.background(), false));
    return result;
}

void addParts(Vec3STree& tree, Exchange& exchange, const Partition& partition,
              const std::vector<VoxelBox<Space::kVelocity>>& wanted, const Period& period)
{
    const Coord next(period.size[0] > 0, period.size[1] > 0, period.size[2] > 0);
    const CoordBBox& mine = partition.box(exchange.rank()).voxels;
    std::vector<Exchange::Bytes> messages(std::size_t(exchange.size()));
    for (int rank = 0; rank < exchange.size(); ++rank) {
        if (rank == exchange.rank()) continue;
        for (CoordBBox::Iterator<true> turn(CoordBBox(-next, next)); turn; ++turn) {
            CoordBBox common = wanted[std::size_t(rank)].voxels;
            common.translate({(*turn)[0] * period.size[0], (*turn)[1] * period.size[1], (*turn)[2] * period.size[2]});
            common.intersect(mine);
            if (common.hasVolume()) messages[std::size_t(rank)] += velocityMessage(tree, common);
        }
    }
    for (const Exchange::Bytes& message : exchange.swap(std::move(messages)))
        readInto(tree, message);
}

openvdb::MaskTree::Ptr joinedTopology(const Vec3STree& part, Exchange& exchange)
{
    struct Leaf {
        Coord origin;
        MaskWords words;
    };
    std::vector<Leaf> leaves;
    visit(
        part, CoordBBox::inf(),
        [&](const VelocityLeaf& leaf) {
            leaves.push_back({leaf.origin(), wordsOf(leaf.getValueMask())});
        },
        [&](const Coord& origin, const Vec3f& /*value*/) {
            leaves.push_back({origin, wordsOf(VelocityLeaf::NodeMaskType(true))});
        });
    auto topology = std::make_shared<openvdb::MaskTree>();
    for (const auto& [origin, words] : exchange.join(leaves)) {
        openvdb::MaskTree::LeafNodeType& leaf = *topology->touchLeaf(origin);
        const VelocityLeaf::NodeMaskType mask = maskOfWords(words), twice = leaf.getValueMask() & mask;
        if (!twice.isOff()) {
            const Coord voxel = leaf.offsetToGlobalCoord(twice.findFirstOn());
            throw InputError(fmt::format("two ranks have the voxel [{}, {}, {}] of the velocity: give each its part "
                                         "without a halo, and its place",
                                         voxel[0], voxel[1], voxel[2]));
        }
        leaf.setValueMask(leaf.getValueMask() | mask);
    }
    return topology;
}

void gatherParts(Vec3STree& part, Exchange& exchange, const Partition& partition)
{
    std::vector<Exchange::Bytes> messages(std::size_t(exchange.size()));
    for (int rank = 0; rank < exchange.size(); ++rank)
        if (rank != exchange.rank()) messages[std::size_t(rank)] = velocityMessage(part, partition.box(rank).voxels);
    for (const Exchange::Bytes& message : exchange.swap(std::move(messages)))
        readInto(part, message);
}

} // namespace vdblic
