#include "vdblic/io/leaf_record.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <istream>

namespace vdblic {
namespace {

/// Append the next bytes of a stream. @return where they begin
char* append(std::vector<char>& bytes, std::istream& stream, std::size_t count)
{
    const std::size_t before = bytes.size();
    bytes.resize(before + count);
    if (count > 0) stream.read(bytes.data() + before, std::streamsize(count));
    return bytes.data() + before;
}

std::size_t activeVoxels(const char* mask)
{
    std::size_t active = 0;
    for (std::size_t i = 0; i < LeafFormat::kMaskBytes; i += sizeof(std::uint64_t)) {
        std::uint64_t word = 0;
        std::memcpy(&word, mask + i, sizeof word);
        active += std::size_t(std::popcount(word));
    }
    return active;
}

} // namespace

std::size_t LeafFormat::headBytes(int kind) const
{
    namespace io = openvdb::io;
    const bool two = kind == io::MASK_AND_TWO_INACTIVE_VALS;
    const bool one = kind == io::NO_MASK_AND_ONE_INACTIVE_VAL || kind == io::MASK_AND_ONE_INACTIVE_VAL;
    const bool selected = two || kind == io::MASK_AND_ONE_INACTIVE_VAL || kind == io::MASK_AND_NO_INACTIVE_VALS;
    return kMaskBytes + 1 + (two ? 2 : one ? 1 : 0) * inactiveBytes + (selected ? kMaskBytes : 0);
}

void appendLeafRecord(std::istream& stream, const LeafFormat& format, std::uint64_t fileSize, std::vector<char>& bytes)
{
    const std::size_t active = activeVoxels(append(bytes, stream, LeafFormat::kMaskBytes));
    const int kind = static_cast<signed char>(*append(bytes, stream, 1));
    append(bytes, stream, format.headBytes(kind) - LeafFormat::kMaskBytes - 1);
    const bool activeOnly = (format.compression & openvdb::io::COMPRESS_ACTIVE_MASK) != 0;
    const std::size_t values = activeOnly && kind != openvdb::io::NO_MASK_AND_ALL_VALS ? active : LeafFormat::kVoxels;
    if ((format.compression & LeafFormat::kCompressed) == 0) {
        append(bytes, stream, values * format.valueBytes);
        return;
    }
    if (format.half && values == 0) return;
    std::int64_t size = 0; // negative if the values are not compressed
    std::memcpy(&size, append(bytes, stream, sizeof size), sizeof size);
    const std::uint64_t count = size < 0 ? -std::uint64_t(size) : std::uint64_t(size);
    if (size <= 0 ? count != values * format.valueBytes : count > fileSize) {
        throw InputError(fmt::format("a leaf's values state a size of {} bytes, which is impossible", count));
    }
    append(bytes, stream, std::size_t(count));
}

} // namespace vdblic
