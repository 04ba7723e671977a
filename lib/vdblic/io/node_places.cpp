#include "vdblic/io/node_places.h"

#include <openvdb/openvdb.h>

namespace vdblic {
namespace {

template<typename Node>
bool hasChildrenInPlace(const Node& node)
{
    if constexpr (Node::LEVEL > 0) {
        for (auto child = node.cbeginChildOn(); child; ++child) {
            if (child->origin() != child.getCoord() || !hasChildrenInPlace(*child)) return false;
        }
    }
    return true;
}

template<typename Root>
bool hasTilesInPlace(const Root& root)
{
    constexpr int kPlace = ~(int(Root::ChildNodeType::DIM) - 1);
    for (auto tile = root.cbeginValueAll(); tile; ++tile) {
        if ((tile.getCoord() & kPlace) != tile.getCoord()) return false;
    }
    return true;
}

} // namespace

bool hasNodesInPlace(const openvdb::GridBase& grid)
{
    bool result = true;
    const bool isKnown = grid.apply<openvdb::GridTypes>([&](const auto& typed) {
        result = hasTilesInPlace(typed.tree().root()) && hasChildrenInPlace(typed.tree().root());
    });
    return isKnown && result;
}

} // namespace vdblic
