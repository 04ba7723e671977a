#include "vdblic/compare/metadata_difference.h"

#include "vdblic/io/affine_rows.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdblic::compare {
namespace {

// Relative errors of numbers that were computed in another order, or stored in another type.
constexpr double kSingleTolerance = 1e-6, kDoubleTolerance = 1e-9;

bool matches(std::string_view key, std::string_view pattern)
{
    if (pattern.ends_with('*')) return key.starts_with(pattern.substr(0, pattern.size() - 1));
    return key == pattern;
}

bool isIgnored(const std::string& key, const std::vector<std::string>& ignored)
{
    return std::any_of(ignored.begin(), ignored.end(),
                       [&](const std::string& pattern) { return matches(key, pattern); });
}

bool same(const openvdb::MetaMap& a, const openvdb::MetaMap& b, const std::string& key)
{
    if (*a[key] == *b[key]) return true;
    // Numbers of different types are compared as doubles; numbers of one integer type were just compared exactly.
    const std::string typeA = a[key]->typeName(), typeB = b[key]->typeName();
    const auto numberA = numericMetadata(a, key), numberB = numericMetadata(b, key);
    if (!numberA || !numberB) return false;
    if (*numberA == *numberB) return typeA != "int64" || typeB != "int64";
    if (std::isnan(*numberA) || std::isnan(*numberB)) return std::isnan(*numberA) && std::isnan(*numberB);
    const bool single = typeA == "float" || typeB == "float";
    const bool fraction = single || typeA == "double" || typeB == "double";
    const double larger = std::max(std::abs(*numberA), std::abs(*numberB));
    return fraction && std::abs(*numberA - *numberB) <= (single ? kSingleTolerance : kDoubleTolerance) * larger;
}

/// With as many digits as tell a number from every other.
std::string textOf(const openvdb::MetaMap& map, const std::string& key)
{
    if (const auto single = map.getMetadata<openvdb::FloatMetadata>(key)) return fmt::format("{}", single->value());
    if (const auto number = map.getMetadata<openvdb::DoubleMetadata>(key)) return fmt::format("{}", number->value());
    return map[key]->str();
}

std::string matrixText(const openvdb::math::Transform& transform)
{
    if (!transform.isLinear()) {
        const openvdb::Vec3d size = transform.voxelSize();
        return fmt::format("{}, voxel size {} {} {}", transform.mapType(), size.x(), size.y(), size.z());
    }
    const openvdb::Mat4d matrix = affineRows(transform);
    std::string text;
    for (int row = 0; row < 4; ++row) {
        text += fmt::format("{}{} {} {}", row > 0 ? ", " : "", matrix(row, 0), matrix(row, 1), matrix(row, 2));
    }
    return text;
}

/// The largest distance between a box corner under the two transforms, in voxels of the finer one.
double largestShift(const openvdb::math::Transform& a, const openvdb::math::Transform& b, const openvdb::CoordBBox& box)
{
    double shift = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const openvdb::Vec3d index(double(corner & 1 ? box.max().x() : box.min().x()),
                                   double(corner & 2 ? box.max().y() : box.min().y()),
                                   double(corner & 4 ? box.max().z() : box.min().z()));
        const openvdb::Vec3d sizeA = a.voxelSize(index), sizeB = b.voxelSize(index);
        double voxel = sizeA[0];
        for (int axis = 0; axis < 3; ++axis)
            voxel = std::min({voxel, sizeA[axis], sizeB[axis]});
        shift = std::max(shift, (a.indexToWorld(index) - b.indexToWorld(index)).length() / voxel);
    }
    return shift;
}

} // namespace

std::vector<MetadataDifference> compareMetadata(const openvdb::MetaMap& a, const openvdb::MetaMap& b,
                                                const std::vector<std::string>& ignored)
{
    std::map<std::string, MetadataDifference> differences; // sorted by name
    const auto note = [&](const std::string& key) {
        if (isIgnored(key, ignored) || differences.contains(key)) return;
        if (a[key] && b[key] && same(a, b, key)) return;
        const auto text = [&](const openvdb::MetaMap& map) {
            return map[key] ? std::optional(textOf(map, key)) : std::nullopt;
        };
        differences[key] = {key, text(a), text(b)};
    };
    for (auto it = a.beginMeta(); it != a.endMeta(); ++it)
        note(it->first);
    for (auto it = b.beginMeta(); it != b.endMeta(); ++it)
        note(it->first);
    std::vector<MetadataDifference> result;
    result.reserve(differences.size());
    for (auto& [key, difference] : differences)
        result.push_back(std::move(difference));
    return result;
}

std::optional<TransformDifference> compareTransforms(const openvdb::GridBase& a, const openvdb::GridBase& b,
                                                     double tolerance)
{
    const openvdb::math::Transform &transformA = a.transform(), &transformB = b.transform();
    // OpenVDB's comparison of transforms has a tolerance of its own, so it is used only where there is no matrix.
    const bool linear = transformA.isLinear() && transformB.isLinear();
    if (linear ? affineRows(transformA) == affineRows(transformB) : transformA == transformB) return std::nullopt;
    openvdb::CoordBBox box = a.evalActiveVoxelBoundingBox();
    box.expand(b.evalActiveVoxelBoundingBox());
    if (box.empty()) box.reset({0, 0, 0}, {1, 1, 1});
    // A box of one voxel has no extent that would show a scale or a rotation.
    box.expand(1);
    const double shift = largestShift(transformA, transformB, box);
    if (linear && shift <= tolerance) return std::nullopt;
    return TransformDifference{matrixText(transformA), matrixText(transformB), shift};
}

} // namespace vdblic::compare
