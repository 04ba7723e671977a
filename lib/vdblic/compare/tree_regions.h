#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <map>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdblic::compare {

/// A box of index space in which each of two trees has one leaf or one constant.
///
/// The pointers are into the trees.
template<typename TreeT>
struct Region {
    using Leaf = typename TreeT::LeafNodeType;
    using Value = typename TreeT::ValueType;

    /// One tree in the box: a leaf, or `value` everywhere.
    struct Side {
        const Leaf* leaf = nullptr;
        const Value* value = nullptr;
        bool active = false;
    };
    openvdb::Coord origin;
    std::uint64_t voxels = Leaf::NUM_VOXELS;
    Side a, b;
};

/// Splits two trees into regions: it descends to leaves only where one of the trees has leaves.
template<typename TreeT>
class RegionFinder {
  public:
    using Value = typename TreeT::ValueType;
    using Leaf = typename TreeT::LeafNodeType;
    using Root = typename TreeT::RootNodeType;

    /// @param all whether to keep constant regions that are inactive in both trees
    RegionFinder(const TreeT& a, const TreeT& b, bool all) : mAll(all)
    {
        using Top = typename Root::ChildNodeType;
        std::map<openvdb::Coord, std::pair<Side<Top>, Side<Top>>> table;
        const Side<Top> emptyA{nullptr, &a.background(), false}, emptyB{nullptr, &b.background(), false};
        const auto entry = [&](const openvdb::Coord& origin) -> auto&
        {
            return table.try_emplace(origin, emptyA, emptyB).first->second;
        };
        const auto enter = [&](const Root& root, auto pick) {
            for (auto it = root.cbeginChildOn(); it; ++it)
                pick(entry(it.getCoord())) = {&*it, nullptr, false};
            for (auto it = root.cbeginValueAll(); it; ++it) {
                pick(entry(it.getCoord())) = {nullptr, &it.getValue(), it.isValueOn()};
            }
        };
        enter(
            a.root(), [](auto& pair) -> auto& { return pair.first; });
        enter(
            b.root(), [](auto& pair) -> auto& { return pair.second; });
        for (const auto& [origin, sides] : table)
            visit(sides.first, sides.second, origin);
    }

    /// The order depends only on the positions of the regions.
    [[nodiscard]] const std::vector<Region<TreeT>>& regions() const { return mRegions; }

  private:
    /// One tree at a level: a node, or a constant.
    template<typename NodeT>
    struct Side {
        const NodeT* node = nullptr;
        const Value* value = nullptr;
        bool active = false;
    };

    template<typename NodeT>
    void visit(const Side<NodeT>& a, const Side<NodeT>& b, const openvdb::Coord& origin)
    {
        if (!a.node && !b.node) {
            if (mAll || a.active || b.active) add(origin, NodeT::NUM_VOXELS, a, b);
        } else if constexpr (NodeT::LEVEL == 0) {
            add(origin, NodeT::NUM_VOXELS, a, b);
        } else {
            using Child = typename NodeT::ChildNodeType;
            typename NodeT::NodeMaskType slots;
            if (mAll) slots.setOn();
            include(slots, a);
            include(slots, b);
            for (auto slot = slots.beginOn(); slot; ++slot) {
                openvdb::Coord corner;
                NodeT::offsetToLocalCoord(slot.pos(), corner);
                corner <<= Child::TOTAL;
                visit(below(a, slot.pos()), below(b, slot.pos()), corner + origin);
            }
        }
    }

    template<typename NodeT>
    static void include(typename NodeT::NodeMaskType& slots, const Side<NodeT>& side)
    {
        if (side.node) {
            slots |= side.node->getChildMask();
            slots |= side.node->getValueMask();
        } else if (side.active) {
            slots.setOn();
        }
    }

    template<typename NodeT>
    static Side<typename NodeT::ChildNodeType> below(const Side<NodeT>& side, openvdb::Index slot)
    {
        if (!side.node) return {nullptr, side.value, side.active};
        const auto& entry = side.node->getTable()[slot];
        if (side.node->getChildMask().isOn(slot)) return {entry.getChild(), nullptr, false};
        return {nullptr, &entry.getValue(), side.node->getValueMask().isOn(slot)};
    }

    template<typename NodeT>
    void add(const openvdb::Coord& origin, std::uint64_t voxels, const Side<NodeT>& a, const Side<NodeT>& b)
    {
        const auto side = [](const Side<NodeT>& s) -> typename Region<TreeT>::Side {
            if constexpr (std::is_same_v<NodeT, Leaf>)
                return {s.node, s.value, s.active};
            else
                return {nullptr, s.value, s.active};
        };
        mRegions.push_back({origin, voxels, side(a), side(b)});
    }

    bool mAll;
    std::vector<Region<TreeT>> mRegions;
};

} // namespace vdblic::compare
