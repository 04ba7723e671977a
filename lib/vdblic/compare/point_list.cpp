#include "vdblic/compare/point_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace vdblic::compare {

using namespace openvdb;
using namespace openvdb::points;

PointList::PointList(const PointDataGrid& grid) : mName(grid.getName()), mTransform(grid.transformPtr()), mFirst{0}
{
    std::vector<const PointLeaf*> leaves;
    grid.tree().getNodes(leaves);
    for (const PointLeaf* leaf : leaves) {
        std::uint64_t count = 0;
        bool rising = true;
        for (Index n = 0; n < PointLeaf::SIZE; ++n) {
            const std::uint64_t end = leaf->getValue(n);
            rising = rising && end >= count;
            count = end;
        }
        if (count == 0) continue;
        const AttributeArray* positions = leaf->attributeSet().getConst("P");
        if (!rising || !positions || positions->size() != count || !positions->hasValueType<Vec3f>()) {
            throw InputError(fmt::format("grid '{}': the leaf at {} {} {} does not hold the {} points it counts; write "
                                         "the file anew",
                                         mName, leaf->origin().x(), leaf->origin().y(), leaf->origin().z(), count));
        }
        mLeaves.push_back(leaf);
        mFirst.push_back(mFirst.back() + count);
    }
}

Coord PointList::voxelOf(std::uint64_t point) const
{
    const auto leaf = std::size_t(std::upper_bound(mFirst.begin(), mFirst.end(), point) - mFirst.begin() - 1);
    Index n = 0;
    while (mLeaves[leaf]->getValue(n) <= point - mFirst[leaf])
        ++n;
    return mLeaves[leaf]->offsetToGlobalCoord(n);
}

std::string PointList::typeOf(const std::string& attribute) const
{
    if (mLeaves.empty()) return {};
    const AttributeArray* array = mLeaves.front()->attributeSet().getConst(attribute);
    if (!array) return {};
    const std::string type = isString(*array) ? "string" : array->valueType();
    return array->stride() == 1 ? type : fmt::format("{}[{}]", type, array->stride());
}

std::vector<std::string> PointList::attributes() const
{
    std::vector<std::string> names;
    if (mLeaves.empty()) return names;
    const AttributeSet& set = mLeaves.front()->attributeSet();
    for (const auto& [name, position] : set.descriptor().map()) {
        if (!isGroup(*set.getConst(position))) names.push_back(name);
    }
    return names;
}

std::vector<std::string> PointList::groups() const
{
    std::vector<std::string> names;
    if (mLeaves.empty()) return names;
    for (const auto& entry : mLeaves.front()->attributeSet().descriptor().groupMap())
        names.push_back(entry.first);
    return names;
}

unsigned PointList::strideOf(const std::string& attribute) const
{
    return arrayOf(0, attribute).stride();
}

std::unique_ptr<bool[]> PointList::membership(const std::string& group) const
{
    auto result = std::make_unique<bool[]>(size());
    forEachLeaf([&](std::size_t leaf) {
        if (!mLeaves[leaf]->attributeSet().descriptor().hasGroup(group)) return;
        const GroupHandle handle = mLeaves[leaf]->groupHandle(group);
        for (Index n = 0; n < mFirst[leaf + 1] - mFirst[leaf]; ++n)
            result[mFirst[leaf] + n] = handle.get(n);
    });
    return result;
}

std::unique_ptr<Vec3d[]> PointList::positions() const
{
    auto result = std::make_unique<Vec3d[]>(size());
    forEachLeaf([&](std::size_t number) {
        const PointLeaf& leaf = *mLeaves[number];
        const AttributeHandle<Vec3f> handle(arrayOf(number, "P"));
        Index n = 0;
        for (Index voxel = 0; voxel < PointLeaf::SIZE; ++voxel) {
            const Vec3d centre = leaf.offsetToGlobalCoord(voxel).asVec3d();
            for (const Index end = leaf.getValue(voxel); n < end; ++n) {
                result[mFirst[number] + n] = mTransform->indexToWorld(centre + Vec3d(handle.get(n)));
            }
        }
    });
    return result;
}

const AttributeArray& PointList::arrayOf(std::size_t leaf, const std::string& attribute) const
{
    const AttributeArray* array = mLeaves[leaf]->attributeSet().getConst(attribute);
    const AttributeArray* first = mLeaves.front()->attributeSet().getConst(attribute);
    if (!array || array->size() != mFirst[leaf + 1] - mFirst[leaf] || array->valueType() != first->valueType() ||
        array->stride() != first->stride() || !array->hasConstantStride()) {
        throw InputError(fmt::format("grid '{}': attribute '{}' is not of one type and of constant size in every leaf "
                                     "and cannot be compared",
                                     mName, attribute));
    }
    return *array;
}

} // namespace vdblic::compare
