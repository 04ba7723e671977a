#include "vdblic/volume/coarse_scalar.h"

#include <cmath>
#include <cstddef>
#include <limits>

namespace vdblic {
namespace {

/// Where the voxels of a cube lie along one axis: the first coarse voxel, and for each voxel the cell and the fraction.
struct AxisCells {
    int first, count; // coarse voxels
    int cell[CoarseScalar::kMostDim];
    float fraction[CoarseScalar::kMostDim];

    AxisCells(int firstVoxel, int dim, const Refinement& refinement, int axis)
    {
        const auto at = [&](int i) {
            return double(firstVoxel + i) * double(refinement.scale(axis)) + double(refinement.shift(axis));
        };
        first = int(std::floor(at(0)));
        count = int(std::floor(at(dim - 1))) + 2 - first;
        for (int i = 0; i < dim; ++i) {
            cell[i] = int(std::floor(at(i))) - first;
            fraction[i] = float(at(i) - std::floor(at(i)));
        }
    }
};

} // namespace

std::optional<CoarseScalar> CoarseScalar::of(const openvdb::FloatGrid& scalar, const openvdb::FloatGrid& texture)
{
    if (!scalar.transform().isLinear()) return std::nullopt;
    const std::optional<Refinement> refinement = Refinement::between(scalar.transform(), texture.transform());
    if (!refinement || refinement->isNone()) return std::nullopt;
    return CoarseScalar(scalar, *refinement);
}

void CoarseScalar::sample(const openvdb::Coord& first, int dim, float* values) const
{
    const AxisCells x(first[0], dim, mRefinement, 0), y(first[1], dim, mRefinement, 1),
        z(first[2], dim, mRefinement, 2);
    constexpr int kMost = kMostDim + 2;
    float coarse[kMost][kMost][kMost], weight[kMost][kMost][kMost]; // values times weights, weights
    openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor(mTree);
    for (int i = 0; i < x.count; ++i) {
        for (int j = 0; j < y.count; ++j) {
            for (int k = 0; k < z.count; ++k) {
                float value = 0;
                const bool isActive =
                    accessor.probeValue({x.first + i, y.first + j, z.first + k}, value) && std::isfinite(value);
                weight[i][j][k] = isActive ? 1.0f : 0.0f;
                coarse[i][j][k] = isActive ? value : 0;
            }
        }
    }
    for (int i = 0; i < dim; ++i) {
        for (int j = 0; j < dim; ++j) {
            const float fx = x.fraction[i], fy = y.fraction[j];
            const float shares[2][2] = {{(1 - fx) * (1 - fy), (1 - fx) * fy}, {fx * (1 - fy), fx * fy}};
            float columnValues[kMost], columnWeights[kMost]; // along z, between the four columns of coarse voxels
            for (int k = 0; k < z.count; ++k) {
                columnValues[k] = columnWeights[k] = 0;
                for (int a = 0; a < 2; ++a) {
                    for (int b = 0; b < 2; ++b) {
                        columnValues[k] += shares[a][b] * coarse[x.cell[i] + a][y.cell[j] + b][k];
                        columnWeights[k] += shares[a][b] * weight[x.cell[i] + a][y.cell[j] + b][k];
                    }
                }
            }
            float* const row = values + std::ptrdiff_t(i * dim + j) * dim;
            for (int k = 0; k < dim; ++k) {
                const int cell = z.cell[k];
                const float fz = z.fraction[k];
                const float sum = (1 - fz) * columnValues[cell] + fz * columnValues[cell + 1];
                const float share = (1 - fz) * columnWeights[cell] + fz * columnWeights[cell + 1];
                row[k] = share > 0 ? sum / share : std::numeric_limits<float>::quiet_NaN();
            }
        }
    }
}

} // namespace vdblic
