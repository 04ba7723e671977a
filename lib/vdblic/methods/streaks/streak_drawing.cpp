#include "vdblic/methods/streaks/streak_drawing.h"

#include "vdblic/field/domain_rows.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"
#include "vdblic/methods/streaks/streak_pieces.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace vdblic {
namespace {

using FloatLeaf = openvdb::FloatTree::LeafNodeType;

/// A piece, and a texture leaf in its reach: the leaf's number among the leaves over one velocity leaf.
struct PieceInLeaf {
    std::uint32_t inside, piece;
};

/// The texture's leaves over the velocity's leaves, by number.
class TextureLeaves {
  public:
    TextureLeaves(const Domain& domain, const Refinement& refinement) : mDomain(domain), mRefinement(refinement)
    {
        openvdb::CoordBBox velocity;
        if (!domain.topology().evalLeafBoundingBox(velocity)) return;
        for (int axis = 0; axis < 3; ++axis) {
            const int factor = refinement.factors[std::size_t(axis)];
            mBox.min()[axis] = velocity.min()[axis] * factor;
            mBox.max()[axis] = velocity.max()[axis] * factor + factor - 1;
        }
    }

    /// Visit the own leaves in reach of a box of texture voxels: the velocity's leaf, and the leaf's number over it.
    template<typename Visit>
    void forReached(openvdb::CoordBBox box, const Visit& visit) const
    {
        box.intersect(mBox);
        if (box.empty()) return;
        const openvdb::Coord first = leafOf(box.min()), last = leafOf(box.max());
        for (openvdb::CoordBBox::Iterator<true> leaf(openvdb::CoordBBox(first, last)); leaf; ++leaf) {
            Int4 coarse{};
            int inside = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const int factor = mRefinement.factors[std::size_t(axis)];
                coarse[axis] = mRefinement.coarseLeaf((*leaf)[axis], axis);
                inside = inside * factor + ((*leaf)[axis] - coarse[axis] * factor);
                coarse[axis] *= LeafVoxel::kDim;
            }
            const int number = mDomain.findLeaf(coarse);
            if (number >= 0 && mDomain.isOwn(std::size_t(number))) visit(std::size_t(number), std::uint32_t(inside));
        }
    }

    [[nodiscard]] std::size_t coarseCount() const { return mDomain.leafCount(); }
    /// @param coarse the velocity's leaf  @param inside number of the leaf over it
    [[nodiscard]] openvdb::Coord origin(std::size_t coarse, std::uint32_t inside) const
    {
        const auto& [x, y, z] = mRefinement.factors;
        const openvdb::Coord origin = mDomain.origin(coarse);
        const int i = int(inside);
        return {origin[0] * x + i / (y * z) * LeafVoxel::kDim, origin[1] * y + i / z % y * LeafVoxel::kDim,
                origin[2] * z + i % z * LeafVoxel::kDim};
    }

  private:
    [[nodiscard]] static openvdb::Coord leafOf(const openvdb::Coord& voxel)
    {
        return {LeafVoxel::leafCoordinate(voxel[0]), LeafVoxel::leafCoordinate(voxel[1]),
                LeafVoxel::leafCoordinate(voxel[2])};
    }

    const Domain& mDomain;
    const Refinement& mRefinement;
    openvdb::CoordBBox mBox; // of the texture's leaves
};

/// Draws pieces into one leaf. One object serves one thread.
class LeafCanvas {
  public:
    LeafCanvas(const std::vector<StreakPiece>& pieces, const std::vector<Streak>& streaks, const StreakShape& shape,
               bool hasSources)
        : mPieces(pieces), mStreaks(streaks), mHasSources(hasSources)
    {
        for (int axis = 0; axis < 3; ++axis)
            mScale[std::size_t(axis)] = 1 / (StreakShape::kRim * shape.radius(axis));
    }

    void begin(const openvdb::Coord& origin)
    {
        mOrigin = origin;
        std::fill_n(mValues.values, LeafVoxel::kCount, 0.0f);
        if (mHasSources) std::fill_n(mOwners.values, LeafVoxel::kCount, -1);
    }

    void draw(std::uint32_t number);

    [[nodiscard]] const float* values() const { return mValues.values; }
    [[nodiscard]] float sourceAt(unsigned offset) const
    {
        return mOwners.values[offset] < 0 ? 0.0f : float(mStreaks[std::size_t(mOwners.values[offset])].source);
    }

  private:
    struct alignas(32) Values {
        float values[LeafVoxel::kCount];
    };
    struct alignas(32) Owners {
        std::int32_t values[LeafVoxel::kCount];
    };

    const std::vector<StreakPiece>& mPieces;
    const std::vector<Streak>& mStreaks;
    bool mHasSources;
    std::array<float, 3> mScale{}; // texture voxels → rims of a head
    openvdb::Coord mOrigin;
    Values mValues{};
    Owners mOwners{}; // numbers of the brightest streaks
};

/// A coordinate as an int; beyond all domains if out of range or NaN.
int bounded(float coordinate)
{
    constexpr float kFar = 0x1p30f;
    return int(coordinate > -kFar ? (coordinate < kFar ? coordinate : kFar) : -kFar);
}

/// The range of a leaf's rows in a piece's reach along an axis. @return whether there are any
bool reachedRows(const StreakPiece& piece, int axis, int origin, float scale, int& first, int& last)
{
    const auto at = std::size_t(axis);
    const float width = std::max(piece.startWidth, piece.endWidth) / scale;
    first = std::max(bounded(std::ceil(std::min(piece.start[at], piece.end[at]) - width)) - origin, 0);
    last =
        std::min(bounded(std::floor(std::max(piece.start[at], piece.end[at]) + width)) - origin, LeafVoxel::kDim - 1);
    return first <= last;
}

/// Ratio of the slope ahead of the head, downstream, to the slope sideways.
constexpr float kHeadSlope = 2;

VDBLIC_KERNEL void drawPiece(const StreakPiece& piece, const openvdb::Coord& origin, const std::array<float, 3>& scale,
                             float* values, std::int32_t* owners, std::int32_t owner, const Streak* streaks)
{
    int first[3], last[3];
    for (int axis = 0; axis < 3; ++axis) {
        if (!reachedRows(piece, axis, origin[axis], scale[std::size_t(axis)], first[axis], last[axis])) return;
    }
    const auto chord = [&](std::size_t axis) { return (piece.end[axis] - piece.start[axis]) * scale[axis]; };
    const float dx = chord(0), dy = chord(1), dz = chord(2);
    const float length2 = dx * dx + dy * dy + dz * dz;
    const float inverse = length2 > 0 ? 1 / length2 : 0;
    const float ahead = piece.isHead ? length2 * (kHeadSlope * kHeadSlope - 1) : 0;
    const Float8 pz = (Float8{0, 1, 2, 3, 4, 5, 6, 7} + (float(origin[2]) - piece.start[2])) * scale[2];
    for (int x = first[0]; x <= last[0]; ++x) {
        const float px = (float(origin[0] + x) - piece.start[0]) * scale[0];
        for (int y = first[1]; y <= last[1]; ++y) {
            const float py = (float(origin[1] + y) - piece.start[1]) * scale[1];
            const Float8 along = (pz * dz + (px * dx + py * dy)) * inverse;
            const Float8 t = along < 0 ? Float8{} : (along > 1 ? broadcast8(1) : along);
            const Float8 over = along > 1 ? along - 1 : Float8{};
            const Float8 ex = px - t * dx, ey = py - t * dy, ez = pz - t * dz;
            const Float8 width = piece.startWidth + t * (piece.endWidth - piece.startWidth);
            const Float8 distance2 = ex * ex + ey * ey + ez * ez + over * over * ahead;
            const Float8 rest = 1 - distance2 / (width * width);
            if (!anyOf(rest > 0)) continue;
            const Float8 value = (piece.startValue + t * (piece.endValue - piece.startValue)) * rest * rest;
            const int row = LeafVoxel::row(x, y);
            const Float8 before = loadRow(values, row);
            Int8 isBrighter = (rest > 0) & (value > before);
            if (owners) {
                const Int8 isEqual = (rest > 0) & (value == before) & (value > 0);
                for (int lane = 0; lane < kLanes; ++lane) {
                    std::int32_t& now = owners[row * LeafVoxel::kDim + lane];
                    const bool isFirst = isEqual[lane] && streaks[owner].name < streaks[now].name;
                    if (isBrighter[lane] || isFirst) now = owner;
                }
            }
            storeRow(isBrighter ? value : before, values, row);
        }
    }
}

void LeafCanvas::draw(std::uint32_t number)
{
    const StreakPiece& piece = mPieces[number];
    drawPiece(piece, mOrigin, mScale, mValues.values, mHasSources ? mOwners.values : nullptr,
              std::int32_t(piece.streak), mStreaks.data());
}

/// The box of texture voxels in a piece's reach.
openvdb::CoordBBox boxOf(const StreakPiece& piece, const StreakShape& shape)
{
    openvdb::CoordBBox box;
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = std::size_t(axis);
        const float width = std::max(piece.startWidth, piece.endWidth) * StreakShape::kRim * shape.radius(axis);
        box.min()[axis] = bounded(std::ceil(std::min(piece.start[at], piece.end[at]) - width));
        box.max()[axis] = bounded(std::floor(std::max(piece.start[at], piece.end[at]) + width));
    }
    return box;
}

/// Add the images of pieces that reach into a periodic box. @param period in voxels of the texture
void addImages(const StreakShape& shape, const Period& period, std::vector<StreakPiece>& pieces)
{
    constexpr int kMost = 8; // along each axis, of pieces that are far too long
    if (period.isNone()) return;
    const std::size_t count = pieces.size();
    for (std::size_t i = 0; i < count; ++i) {
        const openvdb::CoordBBox box = boxOf(pieces[i], shape);
        openvdb::CoordBBox turns(openvdb::Coord(0), openvdb::Coord(0));
        for (int axis = 0; axis < 3; ++axis) {
            const double size = period.size[axis], first = period.first[axis];
            if (size == 0) continue;
            turns.min()[axis] = int(std::ceil((first - box.max()[axis]) / size));
            turns.max()[axis] =
                std::min(int(std::floor((first + size - 1 - box.min()[axis]) / size)), turns.min()[axis] + kMost - 1);
        }
        for (openvdb::CoordBBox::Iterator<true> turn(turns); turn; ++turn) {
            if (*turn == openvdb::Coord(0)) continue;
            StreakPiece image = pieces[i];
            for (int axis = 0; axis < 3; ++axis) {
                const auto way = float((*turn)[axis]) * float(period.size[axis]);
                image.start[std::size_t(axis)] += way;
                image.end[std::size_t(axis)] += way;
            }
            pieces.push_back(image);
        }
    }
}

/// The pieces in reach of each velocity leaf, by a counting sort, in no particular order.
class ReachedLeaves {
  public:
    ReachedLeaves(const std::vector<StreakPiece>& pieces, const StreakShape& shape, const TextureLeaves& leaves)
        : mBegins(leaves.coarseCount() + 1)
    {
        std::vector<std::atomic<std::uint32_t>> counts(leaves.coarseCount());
        const auto forPieces = [&](const auto& visit) {
            tbb::parallel_for(std::size_t(0), pieces.size(), [&](std::size_t i) {
                leaves.forReached(boxOf(pieces[i], shape), [&](std::size_t coarse, std::uint32_t inside) {
                    visit(coarse, PieceInLeaf{inside, std::uint32_t(i)});
                });
            });
        };
        forPieces(
            [&](std::size_t coarse, const PieceInLeaf&) { counts[coarse].fetch_add(1, std::memory_order_relaxed); });
        for (std::size_t i = 0; i < counts.size(); ++i) {
            mBegins[i + 1] = mBegins[i] + counts[i];
            counts[i] = 0;
        }
        mPieces.resize(mBegins.back());
        forPieces([&](std::size_t coarse, const PieceInLeaf& piece) {
            mPieces[mBegins[coarse] + counts[coarse].fetch_add(1, std::memory_order_relaxed)] = piece;
        });
    }

    [[nodiscard]] std::span<PieceInLeaf> in(std::size_t coarse)
    {
        return std::span(mPieces).subspan(mBegins[coarse], mBegins[coarse + 1] - mBegins[coarse]);
    }

  private:
    std::vector<std::size_t> mBegins;
    std::vector<PieceInLeaf> mPieces;
};

using Voxels = FloatLeaf::NodeMaskType;

/// The drawn voxels of a leaf.
VDBLIC_KERNEL Voxels drawnVoxels(const float* values)
{
    Voxels drawn;
    for (int row = 0; row < LeafVoxel::kRows; ++row)
        drawn.getWord<std::uint8_t>(openvdb::Index(row)) =
            std::uint8_t(laneBits(loadRow(values, row) >= kLeastStreakValue));
    return drawn;
}

/// Restrict a texture leaf's voxels to active voxels of the velocity's leaf.
void cutTo(const Domain::Mask& velocity, const Refinement& refinement, const openvdb::Coord& origin, Voxels& drawn)
{
    if (velocity.isOn()) return;
    for (auto voxel = drawn.beginOn(); voxel; ++voxel) {
        const LeafVoxel at = LeafVoxel::at(voxel.pos());
        const openvdb::Coord coarse = refinement.coarse({origin.offsetBy(at.x, at.y, at.z)}).at;
        if (!velocity.isOn(Domain::Leaf::coordToOffset(coarse))) drawn.setOff(voxel.pos());
    }
}

/// Copy the drawn voxels' values; others are 0.
VDBLIC_KERNEL void copyValues(const float* values, const Voxels& drawn, float* to)
{
    for (int row = 0; row < LeafVoxel::kRows; ++row)
        storeRow(activeRow(drawn, row) ? loadRow(values, row) : Float8{}, to, row);
}

std::unique_ptr<FloatLeaf> makeLeaf(const openvdb::Coord& origin, const Voxels& drawn)
{
    auto leaf = std::make_unique<FloatLeaf>(openvdb::PartialCreate(), origin, 0.0f);
    leaf->setValueMask(drawn);
    leaf->allocate();
    return leaf;
}

using FloatLeaves = std::vector<std::unique_ptr<FloatLeaf>>;

openvdb::FloatTree::Ptr treeOf(std::vector<FloatLeaves>& leaves)
{
    auto tree = std::make_shared<openvdb::FloatTree>(0.0f);
    for (FloatLeaves& some : leaves) {
        for (std::unique_ptr<FloatLeaf>& leaf : some)
            tree->addLeaf(leaf.release()); // takes ownership
    }
    return tree;
}

} // namespace

DrawnStreaks drawStreaks(const std::vector<Streak>& streaks, const StreakShape& shape, const Domain& domain,
                         double time, bool hasSources)
{
    std::vector<StreakPiece> pieces = piecesOf(streaks, shape, time);
    addImages(shape, shape.refinement.refined(domain.period()), pieces);
    const TextureLeaves leaves(domain, shape.refinement);
    ReachedLeaves reached(pieces, shape, leaves);
    std::vector<FloatLeaves> textures(leaves.coarseCount()), sources(hasSources ? leaves.coarseCount() : 0);
    tbb::enumerable_thread_specific<LeafCanvas> canvases(pieces, streaks, shape, hasSources);
    tbb::parallel_for(std::size_t(0), leaves.coarseCount(), [&](std::size_t coarse) {
        LeafCanvas& canvas = canvases.local();
        const std::span<PieceInLeaf> all = reached.in(coarse);
        std::sort(all.begin(), all.end(),
                  [](const PieceInLeaf& a, const PieceInLeaf& b) { return a.inside < b.inside; });
        for (std::size_t i = 0; i < all.size();) {
            const std::uint32_t inside = all[i].inside;
            const openvdb::Coord origin = leaves.origin(coarse, inside);
            canvas.begin(origin);
            for (; i < all.size() && all[i].inside == inside; ++i)
                canvas.draw(all[i].piece);
            Voxels drawn = drawnVoxels(canvas.values());
            cutTo(domain.mask(coarse), shape.refinement, origin, drawn);
            if (drawn.isOff()) continue;
            FloatLeaf& texture = *textures[coarse].emplace_back(makeLeaf(origin, drawn));
            copyValues(canvas.values(), drawn, texture.buffer().data());
            if (!hasSources) continue;
            FloatLeaf& source = *sources[coarse].emplace_back(makeLeaf(origin, drawn));
            for (unsigned offset = 0; offset < unsigned(LeafVoxel::kCount); ++offset)
                source.buffer().data()[offset] = drawn.isOn(offset) ? canvas.sourceAt(offset) : 0.0f;
        }
    });
    DrawnStreaks result{treeOf(textures)};
    if (hasSources) result.source = treeOf(sources);
    return result;
}

} // namespace vdblic
