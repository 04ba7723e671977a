#include "vdblic/io/checksum.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <istream>
#include <vector>

namespace vdblic {
namespace {

constexpr std::size_t kDigits = 16;

/// Hashes ranges of a file's bytes.
class RangeHash {
  public:
    explicit RangeHash(std::istream& stream) : mStream(stream), mBlock(std::size_t(1) << 18)
    {
        XXH3_64bits_reset(&mState);
    }

    void add(std::uint64_t begin, std::uint64_t end)
    {
        mStream.seekg(std::streamoff(begin));
        for (std::uint64_t left = end - begin; left > 0;) {
            const std::size_t size = std::size_t(std::min<std::uint64_t>(left, mBlock.size()));
            if (!mStream.read(mBlock.data(), std::streamsize(size))) throw InputError("it cannot be read");
            XXH3_64bits_update(&mState, mBlock.data(), size);
            left -= size;
        }
    }
    /// The hash of the bytes added since the last take().
    std::string take()
    {
        const XXH64_hash_t hash = XXH3_64bits_digest(&mState);
        XXH3_64bits_reset(&mState);
        return fmt::format("{:016x}", hash);
    }

  private:
    std::istream& mStream;
    std::vector<char> mBlock;
    XXH3_state_t mState;
};

} // namespace

std::string emptyChecksums(std::size_t grids)
{
    return fmt::format("{}", fmt::join(std::vector<std::string>(grids + 1, std::string(kDigits, '0')), ","));
}

std::string computeChecksums(std::istream& stream, const VdbLayout& layout)
{
    RangeHash hash(stream);
    hash.add(0, VdbLayout::kIdentityOffset);
    hash.add(VdbLayout::kIdentityOffset + VdbLayout::kIdentityLength, layout.checksum.offset);
    hash.add(layout.checksum.offset + layout.checksum.text.size(), layout.headerEnd);
    std::string text = hash.take();
    for (const VdbLayout::Grid& grid : layout.grids) {
        hash.add(grid.begin, grid.end);
        text += ',' + hash.take();
    }
    return text;
}

std::string identityOf(const std::string& checksums)
{
    const XXH128_hash_t hash = XXH3_128bits(checksums.data(), checksums.size());
    constexpr std::uint64_t kVersion = 0x8000, kVersionBits = 0xf000;
    constexpr std::uint64_t kVariant = std::uint64_t(2) << 62, kVariantBits = std::uint64_t(3) << 62;
    const std::uint64_t high = (hash.high64 & ~kVersionBits) | kVersion;
    const std::uint64_t low = (hash.low64 & ~kVariantBits) | kVariant;
    return fmt::format("{:08x}-{:04x}-{:04x}-{:04x}-{:012x}", high >> 32, high >> 16 & 0xffff, high & 0xffff, low >> 48,
                       low & 0xffff'ffff'ffff);
}

bool hasChecksums(const VdbLayout& layout)
{
    return layout.seekable && layout.checksum.text.size() == emptyChecksums(layout.grids.size()).size() &&
           layout.identity == identityOf(layout.checksum.text);
}

void verifyChecksums(std::istream& stream, const VdbLayout& layout, std::uint64_t size)
{
    const std::string& wanted = layout.checksum.text;
    const std::string found = computeChecksums(stream, layout);
    const auto differs = [&](std::size_t part) {
        const std::size_t at = part * (kDigits + 1);
        return found.compare(at, kDigits, wanted, at, kDigits) != 0;
    };
    std::string damaged;
    for (std::size_t i = 0; i < layout.grids.size(); ++i) {
        if (differs(i + 1)) damaged += fmt::format("{}grid '{}'", damaged.empty() ? "" : ", ", layout.grids[i].name);
    }
    const std::uint64_t end = layout.grids.empty() ? layout.headerEnd : layout.grids.back().end;
    if (damaged.empty() && differs(0)) damaged = "its header";
    if (damaged.empty() && end != size) damaged = "its end";
    if (!damaged.empty()) {
        throw InputError(
            fmt::format("{} is damaged: the checksum is not that of its bytes; make or copy the file again", damaged));
    }
}

} // namespace vdblic
