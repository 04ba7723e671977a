#include "vdblic/volume/scalar_records.h"

#include <array>

namespace vdblic {

ScalarRecords::ScalarRecords(std::size_t leaves, const std::optional<CoarseScalar>& coarse) : mIsCoarse(coarse)
{
    if (coarse) {
        mFirst = kOffsets;
        mSize = kOffsets;
        std::size_t values = 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            mDim[axis] = coarse->dim()[axis];
            mScale[axis] = coarse->scale(int(axis));
            values *= std::size_t(mDim[axis]);
        }
        mSize += values;
    }
    mValues = std::make_unique_for_overwrite<float[]>(leaves * mSize);
}

std::optional<std::array<float, 2>> ScalarRecords::copyCoarse(const CoarseScalar& coarse, std::size_t leaf,
                                                              const openvdb::Coord& origin)
{
    const CoarseScalar::Piece piece = coarse.pieceOf(origin);
    float* const numbers = values(leaf);
    std::copy(piece.offset, piece.offset + 3, numbers);
    numbers[kOffsets - 1] = 0;
    return coarse.copy(piece, numbers + kOffsets);
}

} // namespace vdblic
