#include "vdblic/volume/visible_space.h"

#include "vdblic/look/look.h"
#include "vdblic/volume/texture_volume.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace vdblic {

/// The cells that a leaf's voxels touch: a bit for each that is visible, in rows along z.
struct VisibleSpace::LeafCells {
    std::array<std::uint16_t, std::size_t(kCells) * kCells> rows{};

    [[nodiscard]] bool any() const
    {
        return std::any_of(rows.begin(), rows.end(), [](std::uint16_t row) { return row != 0; });
    }
    [[nodiscard]] bool all() const
    {
        constexpr std::uint16_t kAll = (1u << kCells) - 1;
        return std::all_of(rows.begin(), rows.end(), [](std::uint16_t row) { return row == kAll; });
    }
};

/// The cells of a block, from one before its first voxel on: a bit for each that is visible, in rows along z.
class VisibleSpace::BlockCells {
  public:
    static constexpr int kDim = kBlockDim + 1;

    /// The bits of the cells that a leaf touches, the lowest ones. @param x, y, z the row's first cell
    [[nodiscard]] unsigned row(int x, int y, int z) const
    {
        const std::uint64_t* const words = rowAt(x, y).data() + z / 64;
        const int shift = z % 64;
        const std::uint64_t bits = words[0] >> shift | (shift > 64 - kCells ? words[1] << (64 - shift) : 0);
        return unsigned(bits) & ((1u << kCells) - 1);
    }
    /// Set the bits of a leaf's cells. @param first cell
    void add(const openvdb::Coord& first, const LeafCells& cells)
    {
        for (int i = 0; i < kCells * kCells; ++i) {
            Row& row = rowAt(first[0] + i / kCells, first[1] + i % kCells);
            const int word = first[2] / 64, shift = first[2] % 64;
            row[std::size_t(word)] |= std::uint64_t(cells.rows[std::size_t(i)]) << shift;
            if (shift > 64 - kCells)
                row[std::size_t(word) + 1] |= std::uint64_t(cells.rows[std::size_t(i)]) >> (64 - shift);
        }
    }
    /// Add the neighbours, also those across an edge or a corner, of all cells whose bits are set, and of all cells
    /// outside of the block, about which nothing is known.
    void dilate()
    {
        for (Row& row : mRows) {
            const Row before = row;
            for (std::size_t word = 0; word < kWords; ++word) {
                row[word] |= before[word] << 1 | before[word] >> 1;
                if (word > 0) row[word] |= before[word - 1] >> 63;
                if (word + 1 < kWords) row[word] |= before[word + 1] << 63;
            }
            row.front() |= 1;
            row.back() |= std::uint64_t(1) << (kDim - 1) % 64;
        }
        join(1, kDim, kDim);
        join(kDim, 1, kDim);
    }

  private:
    static constexpr std::size_t kWords = 3;
    static_assert(kDim <= 64 * int(kWords) - 63);
    using Row = std::array<std::uint64_t, kWords>;

    /// Add their neighbours to lines of rows. @param stride of a line's rows  @param next of the lines
    void join(int stride, int next, int lines)
    {
        constexpr Row kAll = {~std::uint64_t(0), ~std::uint64_t(0), ~std::uint64_t(0)};
        for (int line = 0; line < lines; ++line) {
            Row* const rows = mRows.data() + std::ptrdiff_t(line) * next;
            Row before = kAll;
            for (int i = 0; i < kDim; ++i) {
                Row& row = rows[i * std::ptrdiff_t(stride)];
                const Row here = row, &after = i + 1 < kDim ? rows[(i + 1) * std::ptrdiff_t(stride)] : kAll;
                for (std::size_t word = 0; word < kWords; ++word)
                    row[word] |= before[word] | after[word];
                before = here;
            }
        }
    }

    [[nodiscard]] const Row& rowAt(int x, int y) const { return mRows[std::size_t(x) * kDim + std::size_t(y)]; }
    [[nodiscard]] Row& rowAt(int x, int y) { return mRows[std::size_t(x) * kDim + std::size_t(y)]; }

    std::vector<Row> mRows = std::vector<Row>(std::size_t(kDim) * kDim);
};

namespace {

constexpr int kCellDim = VisibleSpace::kCells;

/// The cells of a leaf with a corner whose texture can be seen. @param rows a bit for each cell
VDBLIC_KERNEL
void cellsByTexture(const TextureVolume& volume, const Look& look, std::size_t leaf, std::uint16_t* rows)
{
    const std::int32_t first = volume.scale(leaf).recordAbove(look.hiddenTexture());
    std::uint16_t corners[ScalarLeaf::kDim][ScalarLeaf::kDim]; // a bit for each voxel that can be seen
    for (int x = 0; x < ScalarLeaf::kDim; ++x) {
        for (int y = 0; y < ScalarLeaf::kDim; ++y) {
            const TextureRecord* const row = volume.records(leaf) + TextureLeaf::index(x - 1, y - 1, -1);
            unsigned bits = 0;
            for (const int from : {0, ScalarLeaf::kDim - kLanes}) // twice eight of ten
                bits |= laneBits(loadShorts(row + from, row + from + kLanes / 2) >= first) << from;
            corners[x][y] = std::uint16_t(bits | bits >> 1);
        }
    }
    for (int x = 0; x < kCellDim; ++x) {
        for (int y = 0; y < kCellDim; ++y) {
            const unsigned bits = corners[x][y] | corners[x][y + 1] | corners[x + 1][y] | corners[x + 1][y + 1];
            rows[x * kCellDim + y] = std::uint16_t(bits & ((1u << kCellDim) - 1));
        }
    }
}

/// The extreme values at the corners of a leaf's cells. @param choose the more extreme one of two
template<typename Choose>
VDBLIC_INLINE void extremesOfCells(const float* values, const Choose& choose,
                                   float (&result)[kCellDim][kCellDim][kCellDim])
{
    for (int x = 0; x < kCellDim; ++x) {
        for (int y = 0; y < kCellDim; ++y) {
            const float* const corner = values + std::ptrdiff_t(x * ScalarLeaf::kX + y * ScalarLeaf::kY);
            float ends[ScalarLeaf::kDim];
            for (int z = 0; z < ScalarLeaf::kDim; ++z) {
                ends[z] = choose(choose(corner[z], corner[z + ScalarLeaf::kY]),
                                 choose(corner[z + ScalarLeaf::kX], corner[z + ScalarLeaf::kX + ScalarLeaf::kY]));
            }
            for (int z = 0; z < kCellDim; ++z)
                result[x][y][z] = choose(ends[z], ends[z + 1]);
        }
    }
}

/// Take away the cells whose driver has no opacity anywhere.
VDBLIC_KERNEL
void removeByDriver(const TextureVolume& volume, const Look& look, std::size_t leaf, std::uint16_t* rows)
{
    const LeafRange& range = volume.leafRange(leaf);
    if (volume.drivers().isCoarse() || look.transfer.contributesThroughout(range.lowDriver, range.highDriver)) return;
    float lowest[kCellDim][kCellDim][kCellDim], highest[kCellDim][kCellDim][kCellDim];
    const float* const values = volume.drivers().values(leaf);
    extremesOfCells(
        values, [](float a, float b) { return a < b ? a : b; }, lowest);
    extremesOfCells(
        values, [](float a, float b) { return a > b ? a : b; }, highest);
    for (int row = 0; row < kCellDim * kCellDim; ++row) {
        for (unsigned left = rows[row]; left != 0; left &= left - 1) {
            const int z = __builtin_ctz(left);
            const float low = lowest[row / kCellDim][row % kCellDim][z],
                        high = highest[row / kCellDim][row % kCellDim][z];
            if (!look.transfer.contributes(low, high)) rows[row] &= std::uint16_t(~(1u << z));
        }
    }
}

/// Bytes that grow by one for each bit that is not set.
constexpr std::uint64_t stepsOf(unsigned bits)
{
    std::uint64_t steps = 0;
    for (unsigned z = 0; z < 8; ++z)
        steps |= std::uint64_t(~bits >> z & 1) << 8 * z;
    return steps;
}

constexpr auto kSteps = [] {
    std::array<std::uint64_t, 256> steps{};
    for (unsigned bits = 0; bits < steps.size(); ++bits)
        steps[bits] = stepsOf(bits);
    return steps;
}();

} // namespace

VisibleSpace::LeafCells VisibleSpace::visibleCells(const TextureVolume& volume, const Look& look, std::size_t leaf)
{
    LeafCells cells;
    if (volume.shown(leaf).isOff() || !look.contributes(volume.leafRange(leaf))) return cells;
    cellsByTexture(volume, look, leaf, cells.rows.data());
    if (cells.any()) removeByDriver(volume, look, leaf, cells.rows.data());
    return cells;
}

VisibleSpace::VisibleSpace(const TextureVolume& volume, const Look& look, int farthest)
    : mLeaves(LeafBlock::kCount, kNothing | unsigned(kMostDistance) << kNumberShift),
      mDistances(std::max<std::size_t>(volume.leafCount(), 1) * kCellCount)
{
    const Domain& domain = volume.domain();
    openvdb::CoordBBox box;
    for (std::size_t leaf = 0; leaf < domain.leafCount(); ++leaf)
        box.expand(domain.origin(leaf));
    if (box.empty()) return;
    mOrigin = box.min().offsetBy(-LeafVoxel::kDim);
    for (int axis = 0; axis < 3; ++axis)
        mDim[axis] = (box.max()[axis] - mOrigin[axis]) / kBlockDim + 1;
    mBlocks.assign(std::size_t(mDim[0]) * mDim[1] * mDim[2], kNoBlock);
    std::vector<LeafCells> cells(volume.leafCount());
    tbb::parallel_for(std::size_t(0), cells.size(),
                      [&](std::size_t leaf) { cells[leaf] = visibleCells(volume, look, leaf); });

    std::vector<std::vector<std::uint32_t>> leavesOf(1); // by block
    for (std::size_t leaf = 0; leaf < cells.size(); ++leaf) {
        if (!cells[leaf].any()) continue;
        const openvdb::Coord voxel = volume.origin(leaf) - mOrigin;
        int& block = mBlocks[blockIndex(voxel[0] / kBlockDim, voxel[1] / kBlockDim, voxel[2] / kBlockDim)];
        if (block == kNoBlock) {
            block = int(leavesOf.size());
            leavesOf.emplace_back();
        }
        leavesOf[std::size_t(block)].push_back(std::uint32_t(leaf));
    }
    mLeaves.resize(leavesOf.size() * LeafBlock::kCount, kNothing);
    tbb::parallel_for(1, int(leavesOf.size()),
                      [&](int block) { measure(volume, cells, leavesOf[std::size_t(block)], farthest, block); });
}

/// Make a block's table, and set the distances of its leaves' cells.
void VisibleSpace::measure(const TextureVolume& volume, const std::vector<LeafCells>& cells,
                           const std::vector<std::uint32_t>& leaves, int farthest, int block)
{
    BlockCells bits;
    std::uint32_t* const table = mLeaves.data() + std::size_t(block) * LeafBlock::kCount;
    const auto firstCell = [&](std::size_t leaf) { // one before the leaf's first voxel, in a block that begins so, too
        const openvdb::Coord voxel = volume.origin(leaf) - mOrigin;
        return openvdb::Coord(voxel[0] % kBlockDim, voxel[1] % kBlockDim, voxel[2] % kBlockDim);
    };
    for (const std::uint32_t leaf : leaves) {
        const openvdb::Coord first = firstCell(leaf);
        bits.add(first, cells[leaf]);
        table[LeafBlock::leafIndex(first[0], first[1], first[2])] =
            leaf << kNumberShift | (volume.isPartlyShown(leaf) ? kPartly : 0) | (cells[leaf].all() ? kWhole : 0);
    }
    std::vector<std::uint32_t> open = leaves; // those with cells that no distance reaches yet
    std::vector<int> closed;                  // entries without a visible leaf, likewise
    for (int i = 0; i < LeafBlock::kCount; ++i) {
        if (table[i] & kNothing) closed.push_back(i);
    }
    for (int distance = 0; distance < farthest && !(open.empty() && closed.empty()); ++distance) {
        if (distance > 0) bits.dilate();
        std::erase_if(open, [&](std::uint32_t leaf) {
            const openvdb::Coord first = firstCell(leaf);
            std::uint8_t* at = mDistances.data() + std::size_t(leaf) * kCellCount;
            unsigned all = ~0u;
            for (int row = 0; row < kCells * kCells; ++row, at += kCells) {
                // A cell that several leaves touch is visible as each one's records have it.
                const unsigned set = distance == 0
                                         ? cells[leaf].rows[std::size_t(row)]
                                         : bits.row(first[0] + row / kCells, first[1] + row % kCells, first[2]);
                all &= set;
                std::uint64_t eight;
                std::memcpy(&eight, at, sizeof eight);
                eight += kSteps[set & 0xff];
                std::memcpy(at, &eight, sizeof eight);
                at[8] = std::uint8_t(at[8] + (~set >> 8 & 1));
            }
            return (~all & ((1u << kCells) - 1)) == 0;
        });
        // Without a leaf rays jump over eight voxels anyway.
        constexpr int kFarFromLeaf = 4;
        if (distance == kFarFromLeaf) closed.clear();
        std::erase_if(closed, [&](int i) {
            constexpr int kLeaves = 1 << LeafBlock::kLog2Dim, kDim = LeafVoxel::kDim;
            const int x = i / (kLeaves * kLeaves) * kDim, y = i / kLeaves % kLeaves * kDim, z = i % kLeaves * kDim;
            unsigned any = 0;
            for (int row = 0; row < kCells * kCells; ++row)
                any |= bits.row(x + row / kCells, y + row % kCells, z);
            // It has no records, so no sample in it is visible, whatever its neighbours have in the same cells.
            const bool isReached = distance > 0 && any != 0;
            if (!isReached) table[i] += 1u << kNumberShift;
            return isReached;
        });
    }
}

} // namespace vdblic
