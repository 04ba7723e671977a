#include "vdblic/methods/state_grids.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace vdblic {
namespace {

[[noreturn]] void refuseVoxels(const std::string& grid)
{
    throw InputError(fmt::format("its grid '{}' does not have the voxels of the frame it is for", grid));
}

template<typename T>
openvdb::FloatGrid::Ptr gridOf(const Domain& domain, Domain::Leaves leaves, const LeafValues<T>& values,
                               const std::string& name)
{
    LeafValues<float> copy(domain, 0.0f, leaves);
    forLeaves(leaves, [&](std::size_t leaf) { std::copy_n(values[leaf], LeafVoxel::kCount, copy[leaf]); });
    auto grid = openvdb::FloatGrid::create(copy.tree());
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

} // namespace

std::size_t statePartCount(const Domain& domain)
{
    constexpr std::size_t kLeaves = 4096, kMost = 8;
    return std::clamp((domain.own().size() + kLeaves - 1) / kLeaves, std::size_t(1), kMost);
}

Domain::Leaves statePart(const Domain& domain, std::size_t part)
{
    const Domain::Leaves own = domain.own();
    const std::size_t parts = statePartCount(domain), begin = own.size() * part / parts,
                      end = own.size() * (part + 1) / parts;
    return own.subspan(begin, end - begin);
}

openvdb::CoordBBox boxOf(const Domain& domain, Domain::Leaves leaves)
{
    openvdb::CoordBBox box;
    for (const std::uint32_t leaf : leaves)
        box.expand(domain.origin(leaf), LeafVoxel::kDim);
    return box;
}

openvdb::FloatGrid::Ptr stateGrid(const Domain& domain, Domain::Leaves leaves, const LeafValues<float>& values,
                                  const std::string& name)
{
    return gridOf(domain, leaves, values, name);
}

openvdb::FloatGrid::Ptr stateGrid(const Domain& domain, Domain::Leaves leaves, const LeafValues<std::int32_t>& values,
                                  const std::string& name)
{
    return gridOf(domain, leaves, values, name);
}

StateGridReader::StateGridReader(const Domain& domain, const std::vector<std::string>& names) : mDomain(domain)
{
    for (const std::string& name : names)
        mFound[name].resize(domain.leafCount());
}

void StateGridReader::read(const VdbFile& file, const std::string& name,
                           const std::function<void(std::size_t leaf, const float* values)>& read)
{
    struct StoredLeaf {
        std::size_t number;
        const float* values;
    };
    const auto grid = file.find<openvdb::FloatGrid>(name);
    if (!grid) throw InputError(fmt::format("it has no float grid '{}'", name));
    std::vector<std::uint8_t>& found = mFound.at(name);
    std::vector<StoredLeaf> leaves;
    for (auto leaf = grid->constTree().cbeginLeaf(); leaf; ++leaf) {
        const openvdb::Coord origin = leaf->origin();
        const int number = mDomain.findLeaf(origin);
        const bool fits = number >= 0 ? leaf->getValueMask() == mDomain.mask(std::size_t(number)) : !mDomain.isWhole();
        if (!fits) refuseVoxels(name);
        if (number < 0 || !mDomain.isOwn(std::size_t(number))) continue;
        found[std::size_t(number)] = 1;
        leaves.push_back({std::size_t(number), leaf->buffer().data()});
    }
    tbb::parallel_for(std::size_t(0), leaves.size(), [&](std::size_t i) {
        paging::breathe(paging::kLeafBytes);
        read(leaves[i].number, leaves[i].values);
    });
}

void StateGridReader::finish() const
{
    for (const auto& [name, found] : mFound) {
        const bool isWhole = std::all_of(mDomain.own().begin(), mDomain.own().end(),
                                         [&there = found](std::uint32_t leaf) { return there[leaf] != 0; });
        if (!isWhole) refuseVoxels(name);
    }
}

} // namespace vdblic
