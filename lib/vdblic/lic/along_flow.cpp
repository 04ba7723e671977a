#include "vdblic/lic/along_flow.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/window_box.h"
#include "vdblic/lic/leaf_velocities.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace vdblic {
namespace {

/// The cells around eight positions, and the positions in their cells.
struct Cells {
    Int8 x, y, z;
    Vector8 fraction;

    VDBLIC_INLINE explicit Cells(const Vector8& position)
        : x(floorToInt(position.x)), y(floorToInt(position.y)),
          z(floorToInt(position.z)), fraction{position.x - __builtin_convertvector(x, Float8),
                                              position.y - __builtin_convertvector(y, Float8),
                                              position.z - __builtin_convertvector(z, Float8)}
    {
    }
};

/// The numbers of a leaf and its surroundings, in an array that fits into the first-level cache.
template<int kTaps>
class Surroundings {
  public:
    static constexpr int kRim = kTaps + 1; ///< voxels on each side: positions are rounded, and a cell has two ends
    static constexpr int kDim = LeafVoxel::kDim + 2 * kRim;
    static constexpr int kMargin = (kRim + 3) / 4 * 4; ///< at both ends of a row, so that it is copied by whole vectors
    static constexpr int kRow = LeafVoxel::kDim + 2 * kMargin;

    /// @param row called as row(leaf, row number), returns a pointer to 8 numbers, valid until the next call; leaf −1
    /// is outside the domain
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
                __builtin_memcpy(to - kMargin, row(leaves[0], number) + LeafVoxel::kDim - kMargin,
                                 kMargin * sizeof(float));
                __builtin_memcpy(to, row(leaves[1], number), LeafVoxel::kDim * sizeof(float));
                __builtin_memcpy(to + LeafVoxel::kDim, row(leaves[2], number), kMargin * sizeof(float));
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

    /// Interpolate trilinearly. @param cells counted from the leaf's first voxel, at most kTaps voxels outside the leaf
    [[nodiscard]] VDBLIC_INLINE Float8 at(const Cells& cells) const
    {
        alignas(32) int corners[8];
        alignas(32) float fractions[8];
        storeLanes((cells.x * kDim + cells.y) * kRow + cells.z + index(0, 0, 0), corners);
        storeLanes(cells.fraction.x, fractions);
        Float4 faces[8];
        for (int lane = 0; lane < 8; ++lane) {
            const float* corner = &mValues[std::size_t(unsigned(corners[lane]))];
            const Float4 low = face(corner), high = face(corner + std::ptrdiff_t(kDim) * kRow);
            faces[lane] = low + (high - low) * broadcast4(fractions[lane]);
        }
        Float8 columns[4];
        transpose(faces, columns);
        const Float8 lower = columns[0] + (columns[2] - columns[0]) * cells.fraction.y,
                     upper = columns[1] + (columns[3] - columns[1]) * cells.fraction.y;
        return lower + (upper - lower) * cells.fraction.z;
    }

  private:
    /// The four numbers of a cell's face across x.
    [[nodiscard]] VDBLIC_INLINE static Float4 face(const float* corner)
    {
        double near, far; // two numbers each, which the processor loads together
        __builtin_memcpy(&near, corner, sizeof near);
        __builtin_memcpy(&far, corner + kRow, sizeof far);
        return reinterpret_cast<Float4>(Double2{near, far});
    }
    [[nodiscard]] static constexpr int index(int x, int y, int z)
    {
        return ((x + kRim) * kDim + y + kRim) * kRow + z + kMargin;
    }

    std::array<float, std::size_t(kDim) * kDim * kRow> mValues;
};

/// The domain's coverage as Surroundings would interpolate it, 1 in the box and 0 outside.
/// @param origin of the leaf from which cells are counted
VDBLIC_INLINE Float8 coverageOf(const WindowBox& box, const openvdb::Coord& origin, const Cells& cells)
{
    Float8 coverage = broadcast8(1);
    const auto multiply = [&](int axis, Int8 first, Float8 fraction) {
        const Float8 low = box.holds(axis, first + origin[axis]) ? coverage : Float8{},
                     high = box.holds(axis, first + origin[axis] + 1) ? coverage : Float8{};
        coverage = low + (high - low) * fraction;
    };
    multiply(0, cells.x, cells.fraction.x);
    multiply(1, cells.y, cells.fraction.y);
    multiply(2, cells.z, cells.fraction.z);
    return coverage;
}

/// Filters leaf after leaf. Immutable; any number of threads may use it.
struct AlongFlow {
    const Domain& domain;
    const Refinement& refinement;
    const Velocities<Space::kTexture, Per::kStep>& velocities;
    const LeafValues<float>& texture;

    template<int kTaps>
    VDBLIC_INLINE void filterLeaf(std::size_t leaf, float* result) const
    {
        const openvdb::Coord origin = domain.origin(leaf);
        const LeafWindow window(domain, origin);
        const WindowBox box(domain, window);
        static constexpr std::array<float, LeafVoxel::kDim> kOutside{};
        Surroundings<kTaps> values, coverage;
        values.gather(window, [&](int there, int row) {
            return there < 0 ? kOutside.data() : texture[std::size_t(there)] + row * std::ptrdiff_t(LeafVoxel::kDim);
        });
        if (!box.isExact()) {
            Float8 numbers;
            coverage.gather(window, [&](int there, int row) {
                const unsigned bits =
                    there < 0 ? 0 : domain.mask(std::size_t(there)).getWord<std::uint8_t>(openvdb::Index(row));
                numbers = maskOf(bits) ? broadcast8(1) : Float8{};
                return reinterpret_cast<const float*>(&numbers);
            });
        }
        const LeafVelocities displacements(velocities, refinement, origin);
        const Domain::Mask& mask = domain.mask(leaf);
        for (int row = 0; row < LeafVoxel::kRows; ++row) {
            const unsigned lanes = mask.getWord<std::uint8_t>(openvdb::Index(row));
            if (lanes == 0) continue;
            const Int8 taken = maskOf(lanes);
            const LeafVoxel first = LeafVoxel::ofRow(row);
            const Vector8 centre = rowCentres(first.x, first.y, 0);
            const Vector8 direction = unit(displacements.row(row));
            Float8 sum = values.row(first) * float(kTaps + 1), weights = broadcast8(float(kTaps + 1));
            for (int tap = -kTaps; tap <= kTaps; ++tap) {
                if (tap == 0) continue;
                const Cells cells(centre + direction * float(tap));
                const auto weight = float(kTaps + 1 - std::abs(tap));
                const Float8 value = values.at(cells);
                if (box.isWindow() ||
                    !anyOf(taken & ~box.holdsCell(cells.x + origin[0], cells.y + origin[1], cells.z + origin[2]))) {
                    sum += value * weight;
                    weights += weight;
                } else {
                    const Float8 covered = box.isExact() ? coverageOf(box, origin, cells) : coverage.at(cells);
                    const Int8 counts = covered > 0;
                    sum += counts ? value / covered * weight : Float8{};
                    weights += counts ? broadcast8(weight) : Float8{};
                }
            }
            const Float8 mean = taken ? sum / weights : Float8{};
            __builtin_memcpy(result + row * std::ptrdiff_t(LeafVoxel::kDim), &mean, sizeof mean);
        }
    }

  private:
    /// Unit vectors; 0 where there is no motion or its square overflows.
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
void filterAlong(const AlongFlow& filter, LeafValues<float>& result)
{
    forLeaves(filter.domain.local(), [&](std::size_t leaf) { filterLeafAlong<kTaps>(filter, leaf, result[leaf]); });
}

} // namespace

LeafValues<float> meanAlongFlow(const Domain& domain, const Refinement& refinement,
                                const Velocities<Space::kTexture, Per::kStep>& velocities,
                                const LeafValues<float>& texture, int taps)
{
    if (taps == 0) return texture;
    LeafValues<float> result(domain, 0.0f);
    const AlongFlow filter{domain, refinement, velocities, texture};
    using Filter = void (*)(const AlongFlow&, LeafValues<float>&);
    static constexpr std::array<Filter, kMostTaps> filters = {filterAlong<1>, filterAlong<2>, filterAlong<3>,
                                                              filterAlong<4>};
    filters[std::size_t(taps - 1)](filter, result);
    return result;
}

} // namespace vdblic
