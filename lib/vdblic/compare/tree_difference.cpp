#include "vdblic/compare/tree_difference.h"

#include "vdblic/compare/measure.h"
#include "vdblic/compare/tree_regions.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>
#include <vector>

namespace vdblic::compare {
namespace {

/// Values of equal bits are equal, NaNs too.
bool equalBits(const void* a, const void* b, std::size_t size)
{
    return std::memcmp(a, b, size) == 0;
}

/// Compares one region after another, with buffers for the values of one.
template<typename TreeT>
class RegionMeter {
  public:
    using Value = typename TreeT::ValueType;
    using Leaf = typename TreeT::LeafNodeType;
    using Side = typename Region<TreeT>::Side;
    using M = Metric<Value>;
    static constexpr bool kMask = std::is_same_v<typename TreeT::BuildType, openvdb::ValueMask>;
    static constexpr bool kDirect = !std::is_same_v<Value, bool>; // a leaf stores an array of values

    RegionMeter(const TreeT& a, const TreeT& b, const std::vector<Region<TreeT>>& regions, const CompareParams& params)
        : mRegions(regions), mBackgroundA(a.background()),
          mBackgroundB(b.background()), mTolerances{params.fail, params.relative}, mInactive(params.inactive)
    {
    }

    void operator()(std::size_t number, ValueSums& sums)
    {
        const Region<TreeT>& region = mRegions[number];
        if (region.a.leaf || region.b.leaf)
            addLeaf(region, sums);
        else
            addConstant(region, sums);
    }

  private:
    void addLeaf(const Region<TreeT>& region, ValueSums& sums)
    {
        const BlockMask onA = maskOf(region.a), onB = maskOf(region.b);
        const Value* a = valuesOf(region.a, mValuesA);
        const Value* b = valuesOf(region.b, mValuesB);
        for (std::size_t i = 0; i < onA.size(); ++i) {
            mBlock.compared[i] = onA[i] | onB[i];
            mBlock.onlyA[i] = onA[i] & ~onB[i];
            mBlock.onlyB[i] = onB[i] & ~onA[i];
        }
        if (mInactive && !kMask) addStored(a, b);

        if (onA == onB && equalBits(a, b, sizeof(Value) * kBlockValues)) {
            for (std::size_t n = 0; n < kBlockValues; ++n)
                mBlock.magnitude[n] = M::magnitude(a[n]);
            if (!allFinite(mBlock.magnitude)) dropNotFinite();
            sums.add(sumEqualBlock(mBlock));
            return;
        }
        measure(a, b);
        addBlock(sums, mBlock, mTolerances, [&](std::size_t n) { return indexOf(region.origin, n); });
    }

    void addConstant(const Region<TreeT>& region, ValueSums& sums) const
    {
        const Side &a = region.a, &b = region.b;
        const bool stored = !kMask && (!M::same(*a.value, mBackgroundA) || !M::same(*b.value, mBackgroundB));
        if (!a.active && !b.active && !stored) return;

        ValueSums part;
        const auto count = double(region.voxels);
        const std::uint64_t voxels = region.voxels;
        part.compared = voxels;
        part.onlyInA = a.active && !b.active ? voxels : 0;
        part.onlyInB = b.active && !a.active ? voxels : 0;
        double error = 0, magnitude = 0;
        if constexpr (!kMask) {
            error = errorBetween(*a.value, *b.value);
            magnitude = finiteMagnitude(*a.value, *b.value);
        }
        part.peak = magnitude;
        const bool bad = error == kInfinity;
        const bool over = bad || error > std::max(mTolerances.fail, mTolerances.relative * magnitude);
        part.overFail = over ? voxels : 0;
        part.failing = over || a.active != b.active ? voxels : 0;
        if (bad) {
            part.notFinite = voxels;
            part.max = kInfinity;
        } else {
            part.sum = error * count;
            part.squares = error * error * count;
            part.max = error;
            part.maxRelative = magnitude > 0 ? error / magnitude : error;
            if constexpr (M::kComponents > 0) {
                for (int i = 0; i < M::kComponents && error > 0; ++i) {
                    const double component = M::componentError(*a.value, *b.value, i);
                    part.componentSum[std::size_t(i)] = component * count;
                    part.componentSquares[std::size_t(i)] = component * component * count;
                    part.componentMax[std::size_t(i)] = component;
                }
            }
        }
        if (part.failing > 0) part.first = indexOf(region.origin, 0);
        if (part.max > 0) part.worst = indexOf(region.origin, 0);
        sums.add(part);
    }

    void measure(const Value* a, const Value* b)
    {
        if constexpr (kMask) {
            mBlock.error.fill(0);
            mBlock.magnitude.fill(0);
        } else {
            measureBlock(a, b, mBlock);
        }
    }

    void dropNotFinite()
    {
        for (double& magnitude : mBlock.magnitude) {
            if (!(magnitude <= std::numeric_limits<double>::max())) magnitude = 0;
        }
    }

    /// Also compare inactive values that differ from the background in either grid.
    void addStored(const Value* a, const Value* b)
    {
        for (std::size_t n = 0; n < kBlockValues; ++n) {
            if (!M::same(a[n], mBackgroundA) || !M::same(b[n], mBackgroundB)) setOn(mBlock.compared, n);
        }
    }

    static BlockMask maskOf(const Side& side)
    {
        BlockMask mask;
        if (side.leaf) {
            for (openvdb::Index i = 0; i < mask.size(); ++i) {
                mask[i] = side.leaf->getValueMask().template getWord<std::uint64_t>(i);
            }
        } else {
            mask.fill(side.active ? ~std::uint64_t(0) : 0);
        }
        return mask;
    }

    static const Value* valuesOf(const Side& side, std::array<Value, kBlockValues>& buffer)
    {
        if constexpr (kMask) {
            return buffer.data(); // a mask has no values
        } else if (!side.leaf) {
            buffer.fill(*side.value);
            return buffer.data();
        } else if constexpr (kDirect) {
            return side.leaf->buffer().data();
        } else {
            for (openvdb::Index n = 0; n < kBlockValues; ++n)
                buffer[n] = side.leaf->getValue(n);
            return buffer.data();
        }
    }

    static ValueIndex indexOf(const openvdb::Coord& origin, std::size_t n)
    {
        const auto voxel = origin + Leaf::offsetToLocalCoord(openvdb::Index(n));
        return {voxel.x(), voxel.y(), voxel.z()};
    }

    const std::vector<Region<TreeT>>& mRegions;
    Value mBackgroundA, mBackgroundB;
    Tolerances mTolerances;
    bool mInactive;
    ErrorBlock mBlock;
    std::array<Value, kBlockValues> mValuesA{}, mValuesB{};
};

template<typename GridT>
VoxelDifference describe(const ValueIndex& index, const GridT& a, const GridT& b)
{
    using Value = typename GridT::ValueType;
    using M = Metric<Value>;
    const openvdb::Coord voxel{int(index[0]), int(index[1]), int(index[2])};
    VoxelDifference result;
    result.index = index;
    const openvdb::Vec3d world = a.indexToWorld(voxel);
    result.world = {world.x(), world.y(), world.z()};
    Value valueA, valueB;
    result.activeInA = a.tree().probeValue(voxel, valueA);
    result.activeInB = b.tree().probeValue(voxel, valueB);
    result.a = M::text(valueA);
    result.b = M::text(valueB);
    if constexpr (!RegionMeter<typename GridT::TreeType>::kMask) {
        result.error = errorBetween(valueA, valueB);
    }
    return result;
}

} // namespace

template<typename GridT>
void compareTrees(const GridT& a, const GridT& b, const CompareParams& params, GridDifference& result)
{
    using TreeT = typename GridT::TreeType;
    using Meter = RegionMeter<TreeT>;
    using M = Metric<typename GridT::ValueType>;

    if constexpr (!Meter::kMask) {
        const auto &backgroundA = a.background(), &backgroundB = b.background();
        if (!M::same(backgroundA, backgroundB)) {
            const double tolerance =
                std::max(params.fail, params.relative * std::max(M::magnitude(backgroundA), M::magnitude(backgroundB)));
            if (!(M::error(backgroundA, backgroundB) <= tolerance)) {
                result.background = BackgroundDifference{M::text(backgroundA), M::text(backgroundB)};
            }
        }
    }

    const RegionFinder<TreeT> finder(a.tree(), b.tree(), params.inactive);
    const auto& regions = finder.regions();
    const ValueSums sums =
        sumInOrder(regions.size(), [&] { return std::make_unique<Meter>(a.tree(), b.tree(), regions, params); });

    result.values = finish(sums, M::kComponents, params.failPercent);
    if (sums.first) result.values->first = describe(*sums.first, a, b);
    if (sums.worst) result.values->worst = describe(*sums.worst, a, b);
}

template void compareTrees(const openvdb::FloatGrid&, const openvdb::FloatGrid&, const CompareParams&, GridDifference&);
template void compareTrees(const openvdb::DoubleGrid&, const openvdb::DoubleGrid&, const CompareParams&,
                           GridDifference&);
template void compareTrees(const openvdb::Int32Grid&, const openvdb::Int32Grid&, const CompareParams&, GridDifference&);
template void compareTrees(const openvdb::Int64Grid&, const openvdb::Int64Grid&, const CompareParams&, GridDifference&);
template void compareTrees(const openvdb::BoolGrid&, const openvdb::BoolGrid&, const CompareParams&, GridDifference&);
template void compareTrees(const openvdb::MaskGrid&, const openvdb::MaskGrid&, const CompareParams&, GridDifference&);
template void compareTrees(const openvdb::Vec3SGrid&, const openvdb::Vec3SGrid&, const CompareParams&, GridDifference&);
template void compareTrees(const openvdb::Vec3DGrid&, const openvdb::Vec3DGrid&, const CompareParams&, GridDifference&);
template void compareTrees(const openvdb::Vec3IGrid&, const openvdb::Vec3IGrid&, const CompareParams&, GridDifference&);

} // namespace vdblic::compare
