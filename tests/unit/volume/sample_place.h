#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/volume/texture_volume.h"

#include <openvdb/openvdb.h>

namespace vdblic {

/// Where a sample is, in eight lanes.
struct SamplePlace {
    Unsigned8 leaf;
    Float8 position[3];

    SamplePlace(const TextureVolume& volume, const openvdb::Vec3d& at)
    {
        const openvdb::Coord voxel = openvdb::Coord::round(at);
        leaf = Unsigned8{} + unsigned(volume.domain().findLeaf(Int4{voxel[0], voxel[1], voxel[2]}));
        for (int axis = 0; axis < 3; ++axis)
            position[axis] = broadcast8(float(at[axis] - (voxel[axis] & -LeafVoxel::kDim)));
    }
};

inline float textureAt(const TextureVolume& volume, const openvdb::Vec3d& at)
{
    const SamplePlace place(volume, at);
    return volume.texture().at(place.leaf, Cells(place.position))[0];
}

inline float driverAt(const TextureVolume& volume, const openvdb::Vec3d& at)
{
    const SamplePlace place(volume, at);
    return volume.drivers().at(place.leaf, place.position)[0];
}

/// In world space.
inline float gradientAt(const TextureVolume& volume, const openvdb::Vec3d& at, int axis)
{
    const SamplePlace place(volume, at);
    Float8 g[3];
    volume.texture().gradients(place.leaf, Cells(place.position), g);
    const glm::mat3& toWorld = volume.gradientToWorld();
    return toWorld[0][axis] * g[0][0] + toWorld[1][axis] * g[1][0] + toWorld[2][axis] * g[2][0];
}

} // namespace vdblic
