#pragma once

#include <openvdb/openvdb.h>

#include <type_traits>

namespace vdblic {

/// Leaves on both sides of the origin and of a root node, with every kind of inactive values; tiles of three sizes.
template<typename GridT>
typename GridT::Ptr variedGrid(const char* name)
{
    using Value = typename GridT::ValueType;
    openvdb::initialize();
    const auto value = [](int i) { return Value(std::is_same_v<Value, bool> ? i % 2 : i * 3); };
    auto grid = GridT::create(value(1));
    grid->setName(name);
    auto& tree = grid->tree();
    for (int leaf = 0; leaf < 300; ++leaf) {
        const openvdb::Coord origin(8 * (leaf % 9) - 24, 8 * (leaf / 9 % 9), 8 * (leaf / 81) + (leaf > 250 ? 4080 : 0));
        for (int n = 0; n < 512; n += 1 + leaf % 5) {
            const openvdb::Coord voxel = origin + openvdb::Coord(n / 64, n / 8 % 8, n % 8);
            tree.setValue(voxel, value(n * leaf % 97));
            // So many different inactive values, the background or its negative among them.
            if (n % 3 == 0 && leaf % 7 > 0) tree.setValueOff(voxel, value(n % (leaf % 7) - leaf % 4));
        }
    }
    tree.fill(openvdb::CoordBBox(openvdb::Coord(128), openvdb::Coord(128 + 15)), value(5));
    tree.addTile(2, openvdb::Coord(512, 0, 0), value(7), true);
    tree.addTile(3, openvdb::Coord(4096, 4096, 0), value(9), false);
    tree.touchLeaf(openvdb::Coord(-999)); // no active voxel
    return grid;
}

} // namespace vdblic
