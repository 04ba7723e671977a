#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace vdblic {

struct AdvectPlan;
class Domain;
struct TextureFrame;

/// What one file of a texture sequence holds.
struct TextureFile {
    openvdb::GridCPtrVec grids;
    std::size_t computed = 0;             ///< the number of grids, the first ones, that are not carried along
    std::size_t onTexture = 0;            ///< the number of those, the first ones, that are on the texture's voxels
    std::shared_ptr<const Domain> domain; ///< of the texture
    openvdb::MetaMap metadata;
};

/// Assemble a texture file: the texture, `magnitude` (|v| [world units per second]), the derived grids, the velocity
/// and the hits where the parameters name them, grids carried along from the velocity's file, and the parameters as
/// metadata.
///
/// Textures are finished for display (finish()). Grids other than the texture have the velocity's transform, unless
/// scalars are to have the texture's voxels: then the float grids are interpolated there.
/// @param made   shares its grids with the result; its texture is moved
/// @param number of the output
/// Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] TextureFile makeTextureFile(const AdvectPlan& plan, TextureFrame& made, std::int64_t number);

/// Why a file cannot be the whole texture of a number that a run by this plan has finished; empty if it can.
/// Reads all of its bytes, for their checksums.
[[nodiscard]] std::string faultOf(const std::filesystem::path& output, std::int64_t number, const AdvectPlan& plan);

} // namespace vdblic
