#include "vdblic/streaks/streak_drawing.h"

#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/vector.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

namespace vdblic {
namespace {

using FloatLeaf = openvdb::FloatTree::LeafNodeType;

constexpr float kTail = 0.45f;            // thickness at the tail's end, relative to the head's
constexpr float kSteps = 256;             // between values: what a display shows, in half the bytes on disk
constexpr float kLeastValue = 5 / kSteps; // less cannot be seen
constexpr float kPieceLength = 4;         // texture voxels

/// A straight piece of a streak. Positions are in the texture's index space.
struct Piece {
    std::array<float, 3> start, end;
    float startValue, endValue;
    float startWidth, endWidth; ///< relative to the head's
    std::uint32_t streak;
};

/// A piece, and a leaf of the texture that it may reach.
struct PieceInLeaf {
    std::uint64_t leaf; ///< number of the velocity's leaf, and of the texture's leaf in it
    std::uint32_t piece;
};

/// The cubic Hermite curve between two nodes.
std::array<float, 3> positionBetween(const StreakNode& a, const StreakNode& b, float u)
{
    const auto duration = float(b.time - a.time);
    std::array<float, 3> position{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float chord = b.position[axis] - a.position[axis];
        const float m0 = a.slope[axis] * duration, m1 = b.slope[axis] * duration;
        position[axis] = a.position[axis] + ((m0 + m1 - 2 * chord) * u + (3 * chord - 2 * m0 - m1)) * u * u + m0 * u;
    }
    return position;
}

/// Cuts streaks into pieces.
class PieceCutter {
  public:
    PieceCutter(const StreakShape& shape, double time) : mShape(shape), mTime(time) {}

    void cut(const Streak& streak, std::uint32_t number, std::vector<Piece>& pieces) const
    {
        const auto bright = float(streak.brightness(mTime));
        const double oldest = streak.tailEnd(mTime, double(mShape.tail));
        for (std::size_t i = 1; i < streak.path.size(); ++i) {
            const StreakNode &a = streak.path[i - 1], &b = streak.path[i];
            const double first = std::max(a.time, oldest), last = std::min(b.time, mTime);
            if (!(first < last) || bright * shareAt(last, oldest) < kLeastValue) continue;
            cutCurve(a, b, first, last, oldest, bright, number, pieces);
        }
    }

  private:
    /// How far a time is from the tail's end, 0 to 1 at the head.
    [[nodiscard]] float shareAt(double time, double oldest) const
    {
        return std::clamp(float((time - oldest) / (mTime - oldest)), 0.0f, 1.0f);
    }

    void cutCurve(const StreakNode& a, const StreakNode& b, double first, double last, double oldest, float bright,
                  std::uint32_t number, std::vector<Piece>& pieces) const
    {
        const auto at = [&](double time) {
            return inTexture(positionBetween(a, b, float((time - a.time) / (b.time - a.time))));
        };
        std::array<float, 3> from = at(first);
        const std::array<float, 3> to = at(last);
        float longest = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float slope = std::max(std::abs(a.slope[axis]), std::abs(b.slope[axis])) * float(last - first) *
                                float(mShape.refinement.factors[axis]);
            longest = std::max({longest, slope, std::abs(to[axis] - from[axis])});
        }
        constexpr float kMost = 4096;
        const int count = int(std::ceil(std::clamp(longest / kPieceLength, 1.0f, kMost)));
        for (int i = 1; i <= count; ++i) {
            const double begin = first + (last - first) * (i - 1) / count, end = first + (last - first) * i / count;
            const std::array<float, 3> next = i == count ? to : at(end);
            const float s0 = shareAt(begin, oldest), s1 = shareAt(end, oldest);
            pieces.push_back(
                {from, next, bright * s0, bright * s1, kTail + (1 - kTail) * s0, kTail + (1 - kTail) * s1, number});
            from = next;
        }
    }

    [[nodiscard]] std::array<float, 3> inTexture(std::array<float, 3> position) const
    {
        for (int axis = 0; axis < 3; ++axis) {
            float& coordinate = position[std::size_t(axis)];
            coordinate =
                (coordinate - mShape.refinement.shift(axis)) * float(mShape.refinement.factors[std::size_t(axis)]);
        }
        return position;
    }

    const StreakShape& mShape;
    double mTime;
};

/// The texture's leaves over the velocity's leaves, by number.
class TextureLeaves {
  public:
    TextureLeaves(const Domain& domain, const Refinement& refinement) : mDomain(domain), mRefinement(refinement) {}

    /// Add the own leaves that a box of texture voxels reaches.
    void addReached(const openvdb::CoordBBox& box, std::uint32_t piece, std::vector<PieceInLeaf>& reached) const
    {
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
            if (number < 0 || !mDomain.isOwn(std::size_t(number))) continue;
            reached.push_back(
                {std::uint64_t(number) * std::uint64_t(mRefinement.voxels()) + std::uint64_t(inside), piece});
        }
    }

    /// The velocity's leaf under a leaf.
    [[nodiscard]] std::size_t coarse(std::uint64_t leaf) const { return leaf / std::uint64_t(mRefinement.voxels()); }
    [[nodiscard]] openvdb::Coord origin(std::uint64_t leaf) const
    {
        const auto& [x, y, z] = mRefinement.factors;
        const int inside = int(leaf % std::uint64_t(mRefinement.voxels()));
        const openvdb::Coord origin = mDomain.origin(coarse(leaf));
        return {origin[0] * x + inside / (y * z) * LeafVoxel::kDim, origin[1] * y + inside / z % y * LeafVoxel::kDim,
                origin[2] * z + inside % z * LeafVoxel::kDim};
    }

  private:
    [[nodiscard]] static openvdb::Coord leafOf(const openvdb::Coord& voxel)
    {
        return {LeafVoxel::leafCoordinate(voxel[0]), LeafVoxel::leafCoordinate(voxel[1]),
                LeafVoxel::leafCoordinate(voxel[2])};
    }

    const Domain& mDomain;
    const Refinement& mRefinement;
};

/// Draws pieces into one leaf. One object serves one thread.
class LeafCanvas {
  public:
    LeafCanvas(const std::vector<Piece>& pieces, const std::vector<Streak>& streaks, const StreakShape& shape,
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

    const std::vector<Piece>& mPieces;
    const std::vector<Streak>& mStreaks;
    bool mHasSources;
    std::array<float, 3> mScale{}; // texture voxels → rims of a head
    openvdb::Coord mOrigin;
    Values mValues{};
    Owners mOwners{}; // numbers of the brightest streaks
};

/// The rows of a leaf that a piece reaches: first and last coordinate along an axis. @return whether there are any
bool reachedRows(const Piece& piece, int axis, int origin, float scale, int& first, int& last)
{
    const auto at = std::size_t(axis);
    const float width = std::max(piece.startWidth, piece.endWidth) / scale;
    first = std::max(int(std::ceil(std::min(piece.start[at], piece.end[at]) - width)) - origin, 0);
    last = std::min(int(std::floor(std::max(piece.start[at], piece.end[at]) + width)) - origin, LeafVoxel::kDim - 1);
    return first <= last;
}

VDBLIC_KERNEL void drawPiece(const Piece& piece, const openvdb::Coord& origin, const std::array<float, 3>& scale,
                             float* values, std::int32_t* owners, std::int32_t owner, const Streak* streaks)
{
    int first[3], last[3];
    for (int axis = 0; axis < 3; ++axis) {
        if (!reachedRows(piece, axis, origin[axis], scale[std::size_t(axis)], first[axis], last[axis])) return;
    }
    const auto along = [&](std::size_t axis) { return (piece.end[axis] - piece.start[axis]) * scale[axis]; };
    const float dx = along(0), dy = along(1), dz = along(2);
    const float length2 = dx * dx + dy * dy + dz * dz;
    const float inverse = length2 > 0 ? 1 / length2 : 0;
    const Float8 pz = (Float8{0, 1, 2, 3, 4, 5, 6, 7} + (float(origin[2]) - piece.start[2])) * scale[2];
    for (int x = first[0]; x <= last[0]; ++x) {
        const float px = (float(origin[0] + x) - piece.start[0]) * scale[0];
        for (int y = first[1]; y <= last[1]; ++y) {
            const float py = (float(origin[1] + y) - piece.start[1]) * scale[1];
            Float8 t = (pz * dz + (px * dx + py * dy)) * inverse;
            t = t < 0 ? Float8{} : t;
            t = t > 1 ? broadcast8(1) : t;
            const Float8 ex = px - t * dx, ey = py - t * dy, ez = pz - t * dz;
            const Float8 width = piece.startWidth + t * (piece.endWidth - piece.startWidth);
            const Float8 rest = 1 - (ex * ex + ey * ey + ez * ez) / (width * width);
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
    const Piece& piece = mPieces[number];
    drawPiece(piece, mOrigin, mScale, mValues.values, mHasSources ? mOwners.values : nullptr,
              std::int32_t(piece.streak), mStreaks.data());
}

/// All pieces of all streaks, in the streaks' order.
std::vector<Piece> piecesOf(const std::vector<Streak>& streaks, const StreakShape& shape, double time)
{
    constexpr std::size_t kChunk = 256; // streaks
    const PieceCutter cutter(shape, time);
    std::vector<std::vector<Piece>> chunks((streaks.size() + kChunk - 1) / kChunk);
    tbb::parallel_for(std::size_t(0), chunks.size(), [&](std::size_t chunk) {
        const std::size_t end = std::min((chunk + 1) * kChunk, streaks.size());
        for (std::size_t i = chunk * kChunk; i < end; ++i)
            cutter.cut(streaks[i], std::uint32_t(i), chunks[chunk]);
    });
    std::vector<Piece> pieces;
    std::size_t count = 0;
    for (const std::vector<Piece>& chunk : chunks)
        count += chunk.size();
    pieces.reserve(count);
    for (const std::vector<Piece>& chunk : chunks)
        pieces.insert(pieces.end(), chunk.begin(), chunk.end());
    return pieces;
}

/// The leaves that pieces reach, leaf by leaf.
std::vector<PieceInLeaf> reachedLeaves(const std::vector<Piece>& pieces, const StreakShape& shape,
                                       const TextureLeaves& leaves)
{
    tbb::enumerable_thread_specific<std::vector<PieceInLeaf>> ofThreads;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pieces.size()), [&](const auto& range) {
        std::vector<PieceInLeaf>& reached = ofThreads.local();
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            openvdb::CoordBBox box;
            for (int axis = 0; axis < 3; ++axis) {
                const auto at = std::size_t(axis);
                const Piece& piece = pieces[i];
                const float width = std::max(piece.startWidth, piece.endWidth) * StreakShape::kRim * shape.radius(axis);
                box.min()[axis] = int(std::ceil(std::min(piece.start[at], piece.end[at]) - width));
                box.max()[axis] = int(std::floor(std::max(piece.start[at], piece.end[at]) + width));
            }
            if (!box.empty()) leaves.addReached(box, std::uint32_t(i), reached);
        }
    });
    std::vector<PieceInLeaf> all;
    for (const std::vector<PieceInLeaf>& reached : ofThreads)
        all.insert(all.end(), reached.begin(), reached.end());
    tbb::parallel_sort(all.begin(), all.end(), [](const PieceInLeaf& a, const PieceInLeaf& b) {
        return std::pair(a.leaf, a.piece) < std::pair(b.leaf, b.piece);
    });
    return all;
}

using Voxels = FloatLeaf::NodeMaskType;

/// The voxels of a leaf that something is drawn in.
VDBLIC_KERNEL Voxels drawnVoxels(const float* values)
{
    Voxels drawn;
    for (int row = 0; row < LeafVoxel::kRows; ++row)
        drawn.getWord<std::uint8_t>(openvdb::Index(row)) = std::uint8_t(bitsOf(loadRow(values, row) >= kLeastValue));
    return drawn;
}

/// Cut the voxels of a leaf of the texture to those in active voxels of the velocity's leaf.
void cutTo(const Domain::Mask& velocity, const Refinement& refinement, const openvdb::Coord& origin, Voxels& drawn)
{
    if (velocity.isOn()) return;
    for (auto voxel = drawn.beginOn(); voxel; ++voxel) {
        const LeafVoxel at = LeafVoxel::at(voxel.pos());
        const openvdb::Coord coarse = refinement.coarse(origin.offsetBy(at.x, at.y, at.z));
        if (!velocity.isOn(Domain::Leaf::coordToOffset(coarse))) drawn.setOff(voxel.pos());
    }
}

/// Copy the drawn voxels' values, in steps; others are 0.
VDBLIC_KERNEL void copyValues(const float* values, const Voxels& drawn, float* to)
{
    for (int row = 0; row < LeafVoxel::kRows; ++row) {
        const Int8 isDrawn = Domain::activeRow(drawn, row);
        const Float8 steps = __builtin_convertvector(floorToInt(loadRow(values, row) * kSteps + 0.5f), Float8);
        storeRow(isDrawn ? steps * (1 / kSteps) : Float8{}, to, row);
    }
}

std::unique_ptr<FloatLeaf> makeLeaf(const openvdb::Coord& origin, const Voxels& drawn)
{
    auto leaf = std::make_unique<FloatLeaf>(openvdb::PartialCreate(), origin, 0.0f);
    leaf->setValueMask(drawn);
    leaf->allocate();
    return leaf;
}

openvdb::FloatTree::Ptr treeOf(std::vector<std::unique_ptr<FloatLeaf>>& leaves)
{
    auto tree = std::make_shared<openvdb::FloatTree>(0.0f);
    for (std::unique_ptr<FloatLeaf>& leaf : leaves) {
        if (leaf) tree->addLeaf(leaf.release()); // takes it over
    }
    return tree;
}

} // namespace

DrawnStreaks drawStreaks(const std::vector<Streak>& streaks, const StreakShape& shape, const Domain& domain,
                         double time, bool hasSources)
{
    const std::vector<Piece> pieces = piecesOf(streaks, shape, time);
    const TextureLeaves leaves(domain, shape.refinement);
    const std::vector<PieceInLeaf> reached = reachedLeaves(pieces, shape, leaves);
    std::vector<std::size_t> begins; // of each leaf in `reached`
    for (std::size_t i = 0; i < reached.size(); ++i) {
        if (i == 0 || reached[i].leaf != reached[i - 1].leaf) begins.push_back(i);
    }
    std::vector<std::unique_ptr<FloatLeaf>> textures(begins.size()), sources(hasSources ? begins.size() : 0);
    tbb::enumerable_thread_specific<LeafCanvas> canvases(pieces, streaks, shape, hasSources);
    tbb::parallel_for(std::size_t(0), begins.size(), [&](std::size_t i) {
        LeafCanvas& canvas = canvases.local();
        const std::size_t end = i + 1 < begins.size() ? begins[i + 1] : reached.size();
        const std::uint64_t leaf = reached[begins[i]].leaf;
        const openvdb::Coord origin = leaves.origin(leaf);
        canvas.begin(origin);
        for (std::size_t j = begins[i]; j < end; ++j)
            canvas.draw(reached[j].piece);
        Voxels drawn = drawnVoxels(canvas.values());
        cutTo(domain.mask(leaves.coarse(leaf)), shape.refinement, origin, drawn);
        if (drawn.isOff()) return;
        textures[i] = makeLeaf(origin, drawn);
        copyValues(canvas.values(), drawn, textures[i]->buffer().data());
        if (!hasSources) return;
        sources[i] = makeLeaf(origin, drawn);
        for (unsigned offset = 0; offset < unsigned(LeafVoxel::kCount); ++offset)
            sources[i]->buffer().data()[offset] = drawn.isOn(offset) ? canvas.sourceAt(offset) : 0.0f;
    });
    DrawnStreaks result{treeOf(textures)};
    if (hasSources) result.source = treeOf(sources);
    return result;
}

} // namespace vdblic
