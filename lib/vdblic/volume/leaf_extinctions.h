#pragma once

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

#include <cstddef>

namespace vdblic {

/// The extinctions of a leaf's voxels, hidden ones 0, for all rows along z that have one above 0.
/// @param add called with the row's coordinates in the leaf and its extinctions
template<typename Add>
VDBLIC_INLINE void forExtinctions(const TextureVolume& volume, const Look& look, std::size_t leaf, const Add& add)
{
    const TextureScale scale = volume.scale(leaf);
    const int least = scale.recordAbove(look.hiddenTexture()); // records below are hidden
    for (int x = 0; x < LeafVoxel::kDim; ++x) {
        const auto shown = volume.shown(leaf).getWord<openvdb::Index64>(openvdb::Index(x));
        for (int y = 0; y < LeafVoxel::kDim; ++y) {
            const TextureRecord* const row = volume.records(leaf) + TextureLeaf::index(x, y, 0);
            const Int8 records = loadShorts(row, row + kLanes / 2);
            const Int8 seen = (records >= least) & maskOf(unsigned(shown >> (LeafVoxel::kDim * y)) & 0xff);
            if (!anyOf(seen)) continue;
            const Float8 texture = scale.low + __builtin_convertvector(records, Float8) * scale.perUnit;
            const Float8 density = look.texture.density(look.texture.stretched(texture));
            const Int8 entries = look.transfer.entries(volume.drivers().row(leaf, x, y));
            Float8 extinctions;
            for (int z = 0; z < kLanes; ++z)
                extinctions[z] = look.transfer.extinctions()[entries[z]];
            add(x, y, seen ? extinctions * density : Float8{});
        }
    }
}

} // namespace vdblic
