#include "vdblic/volume/coarse_scalar.h"

#include "vdblic/field/leaf_voxel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

std::optional<CoarseScalar> CoarseScalar::of(const openvdb::FloatGrid& scalar, const openvdb::FloatGrid& texture)
{
    if (!scalar.transform().isLinear()) return std::nullopt;
    const std::optional<Refinement> refinement = Refinement::between(scalar.transform(), texture.transform());
    if (!refinement || refinement->isNone()) return std::nullopt;
    return CoarseScalar(scalar, *refinement);
}

std::array<int, 3> CoarseScalar::dim() const
{
    // Samples lie up to a voxel outside of the leaf's voxels, and depend on the coarse voxels at both ends.
    std::array<int, 3> result{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        result[axis] = (LeafVoxel::kDim + 1) / mRefinement.factors[axis] + 3;
    return result;
}

CoarseScalar::Piece CoarseScalar::pieceOf(const openvdb::Coord& origin) const
{
    Piece piece{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = [&](int voxel) {
            return double(voxel) * double(mRefinement.scale(axis)) + double(mRefinement.shift(axis));
        };
        piece.first[axis] = int(std::floor(at(origin[axis] - 1) - 1e-4)); // whatever a sample's position is rounded to
        piece.offset[axis] = float(at(origin[axis]) - piece.first[axis]);
    }
    return piece;
}

std::optional<std::array<float, 2>> CoarseScalar::copy(const Piece& piece, float* values) const
{
    const std::array<int, 3> dim = this->dim();
    const auto index = [&](const openvdb::Coord& c) { return std::size_t((c[0] * dim[1] + c[1]) * dim[2] + c[2]); };
    const openvdb::CoordBBox box(openvdb::Coord(0), openvdb::Coord(dim[0] - 1, dim[1] - 1, dim[2] - 1));
    std::vector<std::uint8_t> isActive(box.volume());
    std::array<float, 2> range{};
    bool any = false, whole = true;
    openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor(mTree);
    for (const openvdb::Coord& c : box) {
        float& value = values[index(c)];
        const bool active = accessor.probeValue(piece.first + c, value) && std::isfinite(value);
        isActive[index(c)] = active;
        whole = whole && active;
        if (!active) continue;
        range = any ? std::array{std::min(range[0], value), std::max(range[1], value)} : std::array{value, value};
        any = true;
    }
    if (whole) return range;
    for (const openvdb::Coord& c : box) {
        if (isActive[index(c)]) continue;
        float sums[4] = {}, counts[4] = {}; // by the number of axes along which a neighbour differs
        for (const openvdb::Coord& step : openvdb::CoordBBox(openvdb::Coord(-1), openvdb::Coord(1))) {
            if (!box.isInside(c + step) || !isActive[index(c + step)]) continue;
            const int distance = std::abs(step[0]) + std::abs(step[1]) + std::abs(step[2]);
            sums[distance] += values[index(c + step)];
            counts[distance] += 1;
        }
        const auto* const nearest = std::find_if(counts, counts + 4, [](float count) { return count > 0; });
        values[index(c)] = nearest == counts + 4 ? 0 : sums[nearest - counts] / *nearest;
    }
    return any ? std::optional(range) : std::nullopt;
}

} // namespace vdblic
