#include "vdblic/io/guarded_buffer.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <openvdb/io/Compression.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

namespace vdblic {
namespace {

/// Bytes of a stored value by tree type, and of the value in half floats.
struct ValueSize {
    std::string_view type;
    int whole, half;
};
constexpr int kLargestValue = 24; // bytes; for grids of unknown type
constexpr ValueSize kValueSizes[] = {{"Tree_bool_", 1, 1},   {"Tree_mask_", 1, 1},       {"Tree_int32_", 4, 4},
                                     {"Tree_int64_", 8, 8},  {"Tree_half_", 2, 2},       {"Tree_float_", 4, 2},
                                     {"Tree_double_", 8, 2}, {"Tree_vec3i_", 12, 12},    {"Tree_vec3s_", 12, 6},
                                     {"Tree_vec3d_", 24, 6}, {"Tree_ptdataidx32_", 4, 4}};

/// Whether a node mask has this size: that of a leaf (8³) or of a node of 16³ or 32³.
constexpr bool isMask(std::streamsize bytes)
{
    return bytes == 512 / 8 || bytes == 4096 / 8 || bytes == 32768 / 8;
}

std::int64_t countBits(const char* bytes, std::streamsize count)
{
    std::int64_t bits = 0;
    for (std::uint64_t word; count > 0; bytes += sizeof word, count -= sizeof word) {
        std::memcpy(&word, bytes, sizeof word);
        bits += std::popcount(word);
    }
    return bits;
}

} // namespace

void GuardedBuffer::guard(std::istream& stream, const VdbLayout& layout)
{
    mStream = &stream;
    mGrids = layout.grids;
}

std::streamsize GuardedBuffer::xsgetn(char* bytes, std::streamsize count)
{
    if (!mStream) return std::filebuf::xsgetn(bytes, count);
    if (mUncompressed == count && count > allocated()) {
        throw InputError(fmt::format("a node's values state a size of {} bytes, which is impossible", count));
    }
    const std::streamsize done = std::filebuf::xsgetn(bytes, count);
    note(bytes, done);
    return done;
}

void GuardedBuffer::note(const char* bytes, std::streamsize count)
{
    mUncompressed = 0;
    const bool afterMask = std::exchange(mAfterMask, false);
    if (count == sizeof mUncompressed) {
        std::memcpy(&mUncompressed, bytes, sizeof mUncompressed);
        mUncompressed = mUncompressed < 0 ? std::int64_t(-std::uint64_t(mUncompressed)) : 0;
    } else if (count == 1 && afterMask) {
        const int stored = static_cast<unsigned char>(*bytes);
        const bool activeOnly = (openvdb::io::getDataCompression(*mStream) & openvdb::io::COMPRESS_ACTIVE_MASK) != 0;
        if (activeOnly && stored != openvdb::io::NO_MASK_AND_ALL_VALS) mValues = mActive;
        mBeforeSelection = stored == openvdb::io::MASK_AND_NO_INACTIVE_VALS ||
                           stored == openvdb::io::MASK_AND_ONE_INACTIVE_VAL ||
                           stored == openvdb::io::MASK_AND_TWO_INACTIVE_VALS;
    } else if (isMask(count) && !std::exchange(mBeforeSelection, false)) {
        mValues = count * 8;
        mActive = countBits(bytes, count);
        mAfterMask = true;
    }
}

/// Bytes that OpenVDB has allocated for the values of the current node.
std::int64_t GuardedBuffer::allocated()
{
    const auto here = std::uint64_t(std::streamoff(seekoff(0, std::ios::cur, std::ios::in)));
    int bytes = kLargestValue;
    for (const VdbLayout::Grid& grid : mGrids) {
        if (here < grid.begin || here >= grid.end) continue;
        for (const ValueSize& known : kValueSizes) {
            if (grid.type.starts_with(known.type)) bytes = grid.type.ends_with("_HalfFloat") ? known.half : known.whole;
        }
    }
    return mValues * bytes;
}

} // namespace vdblic
