#include "vdblic/lic/accumulator.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/lic/hits.h"

namespace vdblic {

Accumulator::Accumulator(const Domain& domain) : mDomain(domain), mLeaves(domain.leafCount()) {}

void Accumulator::open(Domain::Leaves leaves)
{
    forLeaves(leaves, [&](std::size_t leaf) {
        mLeaves[leaf].reset(new std::int64_t[LeafVoxel::kCount]());
        for (auto voxel = mDomain.mask(leaf).beginOff(); voxel; ++voxel)
            mLeaves[leaf][voxel.pos()] = Hits::kOutside;
    });
}

void Accumulator::close(Domain::Leaves leaves)
{
    for (const std::uint32_t leaf : leaves)
        mLeaves[leaf].reset();
}

} // namespace vdblic
