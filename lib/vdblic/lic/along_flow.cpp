#include "vdblic/lic/along_flow.h"

#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/lic/leaf_velocities.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace vdblic {
namespace {

/// Numbers of a leaf's voxels and of those around it, in an array small enough for the first-level cache.
template<int kTaps>
class Surroundings {
  public:
    static constexpr int kRim = kTaps + 1; ///< voxels on each side: positions are rounded, and a cell has two ends
    static constexpr int kDim = LeafVoxel::kDim + 2 * kRim;

    /// @param row called as row(leaf, number of the row), gives the row's 8 numbers; leaf −1 is outside the domain
    template<typename RowOf>
    VDBLIC_INLINE void gather(const LeafWindow& window, const RowOf& row)
    {
        for (int x = -kRim; x < LeafVoxel::kDim + kRim; ++x) {
            for (int y = -kRim; y < LeafVoxel::kDim + kRim; ++y) {
                float* to = &mValues[std::size_t(index(x, y, 0))];
                const int slot =
                    LeafWindow::slot(LeafVoxel::leafCoordinate(x) + 1, LeafVoxel::leafCoordinate(y) + 1, 0);
                const int* leaves = &window.leaves[std::size_t(slot)];
                const int number = LeafVoxel::row(x, y);
                const Float8 before = row(leaves[0], number), here = row(leaves[1], number),
                             after = row(leaves[2], number);
                for (int i = 0; i < kRim; ++i) {
                    to[i - kRim] = before[LeafVoxel::kDim - kRim + i];
                    to[LeafVoxel::kDim + i] = after[i];
                }
                __builtin_memcpy(to, &here, sizeof here);
            }
        }
    }

    /// The eight numbers of a row of the leaf.
    [[nodiscard]] VDBLIC_INLINE Float8 row(LeafVoxel first) const
    {
        Float8 values;
        __builtin_memcpy(&values, &mValues[std::size_t(index(first.x, first.y, 0))], sizeof values);
        return values;
    }

    /// Interpolate trilinearly. @param position from the leaf's first voxel, at most kTaps voxels outside the leaf
    [[nodiscard]] VDBLIC_INLINE Float8 at(const Vector8& position) const
    {
        const Int8 x = floorToInt(position.x), y = floorToInt(position.y), z = floorToInt(position.z);
        alignas(32) int corners[8];
        const Int8 indices = (x * kDim + y) * kDim + z + index(0, 0, 0);
        __builtin_memcpy(&corners, &indices, sizeof indices);
        const Float8 fx = position.x - __builtin_convertvector(x, Float8),
                     fy = position.y - __builtin_convertvector(y, Float8),
                     fz = position.z - __builtin_convertvector(z, Float8);
        Float4 faces[8];
        for (int lane = 0; lane < 8; ++lane) {
            const float* corner = &mValues[std::size_t(corners[lane])];
            const Float4 low = face(corner), high = face(corner + std::ptrdiff_t(kDim) * kDim);
            faces[lane] = low + (high - low) * fx[lane];
        }
        Float8 columns[4];
        transpose(faces, columns);
        const Float8 lower = columns[0] + (columns[2] - columns[0]) * fy,
                     upper = columns[1] + (columns[3] - columns[1]) * fy;
        return lower + (upper - lower) * fz;
    }

  private:
    /// The four numbers of a cell's face across x.
    [[nodiscard]] VDBLIC_INLINE static Float4 face(const float* corner)
    {
        Float2 near, far;
        __builtin_memcpy(&near, corner, sizeof near);
        __builtin_memcpy(&far, corner + kDim, sizeof far);
        return __builtin_shufflevector(near, far, 0, 1, 2, 3);
    }
    [[nodiscard]] static constexpr int index(int x, int y, int z)
    {
        return ((x + kRim) * kDim + y + kRim) * kDim + z + kRim;
    }

    std::array<float, std::size_t(kDim) * kDim * kDim> mValues;
};

/// Filters leaf after leaf. Immutable; any number of threads may use it.
struct AlongFlow {
    const Domain& domain;
    const Refinement& refinement;
    const VelocityLevel& velocities;
    const LeafValues<float>& texture;

    template<int kTaps>
    VDBLIC_INLINE void filterLeaf(std::size_t leaf, float* result) const
    {
        const openvdb::Coord origin = domain.origin(leaf);
        const LeafWindow window(domain, origin);
        Surroundings<kTaps> values, coverage;
        values.gather(window, [&](int there, int row) {
            Float8 numbers{};
            if (there >= 0) {
                __builtin_memcpy(&numbers, texture[std::size_t(there)] + row * std::ptrdiff_t(LeafVoxel::kDim),
                                 sizeof numbers);
            }
            return numbers;
        });
        const bool isInside = isFull(window);
        if (!isInside) {
            coverage.gather(window, [&](int there, int row) {
                const unsigned bits =
                    there < 0 ? 0 : domain.mask(std::size_t(there)).getWord<std::uint8_t>(openvdb::Index(row));
                return maskOf(bits) ? broadcast8(1) : Float8{};
            });
        }
        const LeafVelocities displacements(velocities, refinement, origin);
        const Domain::Mask& mask = domain.mask(leaf);
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const unsigned lanes = mask.getWord<std::uint8_t>(openvdb::Index(row));
            if (lanes == 0) continue;
            const LeafVoxel first = LeafVoxel::ofRow(row);
            const Vector8 centre = rowCentres(first.x, first.y, 0);
            const Vector8 direction = unit(displacements.row(row));
            Float8 sum = values.row(first) * float(kTaps + 1), weights = broadcast8(float(kTaps + 1));
            for (int tap = -kTaps; tap <= kTaps; ++tap) {
                if (tap == 0) continue;
                const Vector8 position = centre + direction * float(tap);
                const auto weight = float(kTaps + 1 - std::abs(tap));
                if (isInside) {
                    sum += values.at(position) * weight;
                    weights += weight;
                } else {
                    const Float8 covered = coverage.at(position);
                    const Int8 counts = covered > 0;
                    sum += counts ? values.at(position) / covered * weight : Float8{};
                    weights += counts ? broadcast8(weight) : Float8{};
                }
            }
            const Float8 mean = sum / weights;
            for (int z = 0; z < LeafVoxel::kDim; ++z) {
                if (lanes >> z & 1) result[LeafVoxel::kDim * row + z] = mean[z];
            }
        }
    }

  private:
    /// Whether the domain has every voxel of a leaf and of the leaves around it.
    [[nodiscard]] bool isFull(const LeafWindow& window) const
    {
        for (int slot = 0; slot < LeafWindow::kElsewhere; ++slot) {
            const int leaf = window.leaves[std::size_t(slot)];
            if (leaf < 0 || !domain.mask(std::size_t(leaf)).isOn()) return false;
        }
        return true;
    }

    /// Of length 1, or 0 where there is no motion or its square overflows.
    [[nodiscard]] VDBLIC_INLINE static Vector8 unit(const Vector8& v)
    {
        const Float8 squared = squaredLength(v);
        const Int8 moves = (squared > 1e-12f) & (squared < 1e30f);
        const Float8 scale = 1 / squareRoots(moves ? squared : broadcast8(1));
        return {moves ? v.x * scale : Float8{}, moves ? v.y * scale : Float8{}, moves ? v.z * scale : Float8{}};
    }
};

template<int kTaps>
VDBLIC_KERNEL void filterLeafAlong(const AlongFlow& filter, std::size_t leaf, float* result)
{
    filter.filterLeaf<kTaps>(leaf, result);
}

template<int kTaps>
void filterAlong(const AlongFlow& filter, const LeafValues<float>& result)
{
    forLeaves(filter.domain.local(), [&](std::size_t leaf) { filterLeafAlong<kTaps>(filter, leaf, result[leaf]); });
}

} // namespace

LeafValues<float> meanAlongFlow(const Domain& domain, const Refinement& refinement, const VelocityLevel& velocities,
                                const LeafValues<float>& texture, int taps)
{
    if (taps == 0) return texture;
    LeafValues<float> result(domain, 0.0f);
    const AlongFlow filter{domain, refinement, velocities, texture};
    using Filter = void (*)(const AlongFlow&, const LeafValues<float>&);
    static constexpr std::array<Filter, kMostTaps> filters = {filterAlong<1>, filterAlong<2>, filterAlong<3>,
                                                              filterAlong<4>};
    filters[std::size_t(taps - 1)](filter, result);
    return result;
}

} // namespace vdblic
