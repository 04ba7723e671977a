#pragma once

#include "vdblic/core/exchange.h"

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

/// The content of one file of a texture sequence.
struct TextureFile {
    openvdb::GridCPtrVec grids;
    std::size_t computed = 0;             ///< the number of grids, the first ones, that are not carried
    std::size_t onTexture = 0;            ///< the number of those, the first ones, with the texture's voxels
    std::shared_ptr<const Domain> domain; ///< of the texture
    openvdb::MetaMap metadata;
};

/// Assemble a texture file: the texture, `magnitude` (|v| [world units per second]), the derived grids, the velocity
/// and the hits where the parameters name them, grids carried along from the velocity's file, and the parameters as
/// metadata.
///
/// Textures are finished for display (finish()). Other grids have the velocity's transform, except float grids that are
/// to have the texture's voxels and are interpolated there.
/// @param made   shares its grids with the result; its texture is moved
/// @param number of the output
/// @param writer rank that writes the file: it alone gets grids that are not computed. Collective for lines
/// Computed in parallel; the result does not depend on the number of threads.
[[nodiscard]] TextureFile makeTextureFile(const AdvectPlan& plan, TextureFrame& made, std::int64_t number,
                                          Exchange& exchange, int writer);

/// The reason why a file cannot be the finished texture of a number in a run by this plan; empty if it can.
/// Reads all of its bytes, for their checksums.
[[nodiscard]] std::string faultOf(const std::filesystem::path& output, std::int64_t number, const AdvectPlan& plan);

} // namespace vdblic
