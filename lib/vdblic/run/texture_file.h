#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>

namespace vdblic {

struct AdvectParams;
struct LoadedFrame;

/// When a texture is valid.
struct TextureTime {
    std::int64_t frame = 1; ///< number of the output
    double sourceFrame = 1; ///< number of the input; between two frames a fraction
    double time = 0;        ///< seconds
    double interval = 0;    ///< seconds to the next texture
};

/// What one file of a texture sequence holds.
struct TextureFile {
    openvdb::GridCPtrVec grids;
    std::size_t computed = 0; ///< the number of grids, the first ones, that are not carried along
    openvdb::MetaMap metadata;
};

/// Assemble a texture file: the texture, `magnitude` (|v| [world units per second]), the derived grids that the
/// parameters name, grids carried along from the velocity's file, and the parameters as metadata.
///
/// @param frame     velocity of that time; its flow.toWorldPerSecond must be set
/// @param texture   in [0, 1]; shared with the result
/// @param transform of the texture; every other grid has the velocity's transform, unless scalars are to have the
///                  texture's voxels: then the float grids are interpolated there
/// Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] TextureFile makeTextureFile(const AdvectParams& params, const LoadedFrame& frame,
                                          const openvdb::FloatTree::Ptr& texture,
                                          const openvdb::math::Transform& transform, const TextureTime& time);

} // namespace vdblic
