#include "vdblic/methods/auflic/accumulator.h"

#include "vdblic/core/paging.h"
#include "vdblic/lic/hits.h"

#include <tbb/parallel_for.h>

#include <memory>

namespace vdblic {
namespace {

using Leaf = openvdb::Int64Tree::LeafNodeType;

/// A leaf of the domain's voxels, without hits.
std::unique_ptr<Leaf> emptyLeaf(const Domain& domain, std::size_t number)
{
    auto leaf = std::make_unique<Leaf>(domain.origin(number), std::int64_t(0));
    leaf->setValueMask(domain.mask(number));
    std::int64_t* const words = leaf->buffer().data();
    for (auto voxel = domain.mask(number).beginOff(); voxel; ++voxel)
        words[voxel.pos()] = Hits::kOutside;
    return leaf;
}

} // namespace

Accumulator::Accumulator(const Domain& domain)
    : mDomain(domain), mTree(std::make_shared<openvdb::Int64Tree>(Hits::kOutside)), mWords(domain.leafCount(), nullptr)
{
}

void Accumulator::open(Domain::Leaves leaves)
{
    std::vector<std::unique_ptr<Leaf>> opened(leaves.size());
    tbb::parallel_for(std::size_t(0), leaves.size(), [&](std::size_t i) {
        paging::breathe(paging::kLeafBytes);
        opened[i] = emptyLeaf(mDomain, leaves[i]);
        mWords[leaves[i]] = opened[i]->buffer().data();
    });
    for (std::unique_ptr<Leaf>& leaf : opened)
        mTree->addLeaf(leaf.release()); // takes ownership
}

void Accumulator::close(Domain::Leaves leaves)
{
    for (const std::uint32_t number : leaves) {
        const std::unique_ptr<Leaf> leaf(mTree->stealNode<Leaf>(mDomain.origin(number), Hits::kOutside, false));
        mWords[number] = nullptr;
    }
}

} // namespace vdblic
