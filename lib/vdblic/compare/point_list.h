#pragma once

#include "vdblic/core/errors.h"

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace vdblic::compare {

using PointLeaf = openvdb::points::PointDataTree::LeafNodeType;

/// The points of a grid, numbered leaf by leaf and, within a leaf, voxel by voxel.
class PointList {
  public:
    /// @throws InputError if a leaf counts points that it does not hold
    explicit PointList(const openvdb::points::PointDataGrid& grid);

    [[nodiscard]] const std::string& gridName() const { return mName; }
    [[nodiscard]] std::uint64_t size() const { return mFirst.back(); }
    [[nodiscard]] const std::vector<const PointLeaf*>& leaves() const { return mLeaves; }
    [[nodiscard]] std::uint64_t firstOf(std::size_t leaf) const { return mFirst[leaf]; }
    /// The voxel that holds a point.
    [[nodiscard]] openvdb::Coord voxelOf(std::uint64_t point) const;

    /// The type of an attribute, such as "float", "vec3s" or "int32[4]"; empty if there is none.
    [[nodiscard]] std::string typeOf(const std::string& attribute) const;
    /// The names of the attributes, without groups.
    [[nodiscard]] std::vector<std::string> attributes() const;
    [[nodiscard]] std::vector<std::string> groups() const;
    /// The number of values of a point in an attribute.
    [[nodiscard]] unsigned strideOf(const std::string& attribute) const;

    /// The decoded values of all points, strideOf() a point.
    template<typename T>
    [[nodiscard]] std::unique_ptr<T[]> values(const std::string& attribute) const;
    /// Whether each point is in a group.
    [[nodiscard]] std::unique_ptr<bool[]> membership(const std::string& group) const;
    /// World positions.
    [[nodiscard]] std::unique_ptr<openvdb::Vec3d[]> positions() const;

  private:
    [[nodiscard]] const openvdb::points::AttributeArray& arrayOf(std::size_t leaf, const std::string& attribute) const;
    template<typename Fill>
    void forEachLeaf(const Fill& fill) const
    {
        tbb::parallel_for(std::size_t(0), mLeaves.size(), fill);
    }

    std::string mName;
    openvdb::math::Transform::ConstPtr mTransform;
    std::vector<const PointLeaf*> mLeaves;
    std::vector<std::uint64_t> mFirst; // index of each leaf's first point, then the total
};

template<typename T>
std::unique_ptr<T[]> PointList::values(const std::string& attribute) const
{
    const unsigned stride = strideOf(attribute);
    auto result = std::make_unique<T[]>(size() * stride);
    forEachLeaf([&](std::size_t leaf) {
        T* to = result.get() + mFirst[leaf] * stride;
        const auto copy = [&](const auto& handle) {
            for (openvdb::Index n = 0; n < mFirst[leaf + 1] - mFirst[leaf]; ++n) {
                for (openvdb::Index m = 0; m < stride; ++m)
                    *to++ = handle.get(n, m);
            }
        };
        const openvdb::points::AttributeArray& array = arrayOf(leaf, attribute);
        if constexpr (std::is_same_v<T, std::string>) {
            copy(openvdb::points::StringAttributeHandle(array,
                                                        mLeaves[leaf]->attributeSet().descriptor().getMetadata()));
        } else {
            copy(openvdb::points::AttributeHandle<T>(array));
        }
    });
    return result;
}

} // namespace vdblic::compare
