#include "vdblic/field/box_domain.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <cstdint>

namespace vdblic {

void checkBoxSize(const BoxSize& size)
{
    constexpr int kLongest = 100'000; // about the largest index that a Domain supports
    for (const int side : size) {
        if (side < 1 || side > kLongest) {
            throw ParameterError(
                fmt::format("size {} {} {}: each side must be 1 to {} voxels", size[0], size[1], size[2], kLongest));
        }
    }
    const std::int64_t slice = std::int64_t(size[0]) * size[1];
    if (slice > kMaxBoxVoxels / size[2]) {
        throw ParameterError(fmt::format("size {} {} {}: at most {} voxels are supported, choose a smaller box",
                                         size[0], size[1], size[2], kMaxBoxVoxels));
    }
}

void checkVoxelSize(double voxelSize)
{
    constexpr double kLeast = 1e-4, kMost = 1e4;
    if (!(voxelSize >= kLeast && voxelSize <= kMost)) {
        throw ParameterError(fmt::format("voxel size {}: must be {} to {} world units", voxelSize, kLeast, kMost));
    }
}

std::shared_ptr<const Domain> boxDomain(const BoxSize& size)
{
    checkBoxSize(size);
    const openvdb::CoordBBox box(openvdb::Coord(0), openvdb::Coord(size[0] - 1, size[1] - 1, size[2] - 1));
    checkVoxels(box.volume(), "", 1, box.volume());
    auto topology = std::make_shared<openvdb::MaskTree>();
    topology->denseFill(box, true);
    return std::make_shared<const Domain>(topology);
}

} // namespace vdblic
