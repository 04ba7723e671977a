#include "vdblic/field/window_box.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace vdblic {
namespace {

/// Call visit(leaf, x, y, z) for each slot of a window, counted in leaves from its first, until a call returns false.
/// @return whether all calls returned true
template<typename Visit>
bool allLeaves(const LeafWindow& window, const Visit& visit)
{
    std::size_t slot = 0;
    for (int x = 0; x < LeafWindow::kDim; ++x) {
        for (int y = 0; y < LeafWindow::kDim; ++y) {
            for (int z = 0; z < LeafWindow::kDim; ++z) {
                if (!visit(window.leaves[slot++], x, y, z)) return false;
            }
        }
    }
    return true;
}

bool isFull(const Domain& domain, int leaf)
{
    return leaf >= 0 && domain.box(std::size_t(leaf)).isFull;
}

} // namespace

WindowBox::WindowBox(const Domain& domain, const LeafWindow& window)
{
    mIsWindow = allLeaves(window, [&](int leaf, int, int, int) { return isFull(domain, leaf); });
    if (mIsWindow) {
        for (int axis = 0; axis < 3; ++axis)
            set(window, axis, 0, LeafWindow::kDim - 1);
        mIsExact = true;
        return;
    }
    mIsExact = coverWindow(domain, window);
    if (!mIsExact) growFromMiddle(domain, window);
}

/// Set one axis to a range of the window's leaves.
void WindowBox::set(const LeafWindow& window, int axis, int firstLeaf, int lastLeaf)
{
    mFirst[axis] = (window.first[axis] + firstLeaf) * LeafVoxel::kDim;
    mLast[axis] = (window.first[axis] + lastLeaf + 1) * LeafVoxel::kDim - 1;
}

/// Set this to the smallest box around the window's voxels. @return whether the box has no other voxels
bool WindowBox::coverWindow(const Domain& domain, const LeafWindow& window)
{
    constexpr int kVoxels = LeafWindow::kDim * LeafVoxel::kDim;
    int first[3] = {kVoxels, kVoxels, kVoxels}, last[3] = {-1, -1, -1}; // from the window's first voxel
    const bool areBoxes = allLeaves(window, [&](int leaf, int x, int y, int z) {
        if (leaf < 0) return true;
        const LeafBox& box = domain.box(std::size_t(leaf));
        const int place[3] = {x, y, z};
        for (int axis = 0; axis < 3; ++axis) {
            const int origin = place[axis] * LeafVoxel::kDim;
            first[axis] = std::min(first[axis], origin + box.spans[axis].first);
            last[axis] = std::max(last[axis], origin + box.spans[axis].last);
        }
        return box.isExact;
    });
    if (!areBoxes) return false;
    std::array<std::array<LeafSpan, LeafWindow::kDim>, 3> parts; // of the box, in each leaf along each axis
    for (std::size_t axis = 0; axis < 3; ++axis) {
        mFirst[axis] = window.first[axis] * LeafVoxel::kDim + first[axis];
        mLast[axis] = window.first[axis] * LeafVoxel::kDim + last[axis];
        for (int i = 0; i < LeafWindow::kDim; ++i) {
            const int origin = i * LeafVoxel::kDim;
            parts[axis][std::size_t(i)] = {std::int8_t(std::max(first[axis] - origin, 0)),
                                           std::int8_t(std::min(last[axis] - origin, LeafVoxel::kDim - 1))};
        }
    }
    return allLeaves(window, [&](int leaf, int x, int y, int z) {
        const LeafSpan inX = parts[0][std::size_t(x)], inY = parts[1][std::size_t(y)], inZ = parts[2][std::size_t(z)];
        if (inX.isEmpty() || inY.isEmpty() || inZ.isEmpty()) return true; // the leaf is outside the box
        if (leaf < 0) return false;
        const LeafSpan(&has)[3] = domain.box(std::size_t(leaf)).spans;
        return has[0] == inX && has[1] == inY && has[2] == inZ;
    });
}

/// Set this to the middle leaf and full leaves around it; empty if the middle leaf is not full.
void WindowBox::growFromMiddle(const Domain& domain, const LeafWindow& window)
{
    int first[3] = {1, 1, 1}, last[3] = {1, 1, 1}; // leaves of the window along each axis
    const auto areFull = [&] {
        return allLeaves(window, [&](int leaf, int x, int y, int z) {
            const bool isPart =
                x >= first[0] && x <= last[0] && y >= first[1] && y <= last[1] && z >= first[2] && z <= last[2];
            return !isPart || isFull(domain, leaf);
        });
    };
    const bool isEmpty = !areFull();
    for (int axis = 0; axis < 3 && !isEmpty; ++axis) {
        first[axis] = 0;
        if (!areFull()) first[axis] = 1;
        last[axis] = 2;
        if (!areFull()) last[axis] = 1;
    }
    for (int axis = 0; axis < 3; ++axis) {
        set(window, axis, first[axis], last[axis]);
        if (isEmpty) mLast[axis] = mFirst[axis] - 1;
    }
}

} // namespace vdblic
