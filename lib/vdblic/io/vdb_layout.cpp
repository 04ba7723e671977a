#include "vdblic/io/vdb_layout.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <istream>
#include <string_view>

namespace vdblic {
namespace {

constexpr std::int64_t kMagic = 0x56444220;
// Since 218 (2012) the identity is stored as text. OpenVDB 10 to 12 write 224; OpenVDB 13 writes 225, which adds a type
// of grid, of half floats.
constexpr std::uint32_t kFirstVersion = 218, kLastVersion = 225;
constexpr std::uint32_t kSelectiveCompression = 220, kNodeMaskCompression = 222;
constexpr std::uint32_t kCompressionFlags = 7; // zip, active values, blosc
constexpr std::uint32_t kLongestName = 4096;

constexpr std::array<std::string_view, 8> kTransforms = {
    "AffineMap",         "ScaleMap",   "UniformScaleMap",          "TranslationMap",
    "ScaleTranslateMap", "UnitaryMap", "UniformScaleTranslateMap", "NonlinearFrustumMap",
};

/// Metadata types of fixed size. OpenVDB reads that many bytes and ignores the size in the file.
struct FixedSize {
    std::string_view type;
    std::uint32_t bytes;
};
constexpr std::array<FixedSize, 17> kFixedSizes = {{{"bool", 1},
                                                    {"double", 8},
                                                    {"float", 4},
                                                    {"half", 2},
                                                    {"int32", 4},
                                                    {"int64", 8},
                                                    {"vec2i", 8},
                                                    {"vec2s", 8},
                                                    {"vec2d", 16},
                                                    {"vec3i", 12},
                                                    {"vec3s", 12},
                                                    {"vec3d", 24},
                                                    {"vec4i", 16},
                                                    {"vec4s", 16},
                                                    {"vec4d", 32},
                                                    {"mat4s", 64},
                                                    {"mat4d", 128}}};

/// Reads values from a stream, never beyond its end.
class Cursor {
  public:
    Cursor(std::istream& stream, std::uint64_t size) : mStream(stream), mEnd(size) {}

    [[nodiscard]] std::uint64_t at() const { return mAt; }
    [[nodiscard]] std::uint64_t left() const { return mEnd - mAt; }

    /// @param what names the value in the message
    void read(void* bytes, std::uint64_t count, const char* what)
    {
        if (count > left()) throw InputError(fmt::format("it ends too early, in {}", what));
        mStream.read(static_cast<char*>(bytes), std::streamsize(count));
        if (!mStream) throw InputError("it cannot be read");
        mAt += count;
    }
    template<typename T>
    T value(const char* what)
    {
        T result{};
        read(&result, sizeof result, what);
        return result;
    }
    std::string text(std::uint32_t longest, const char* what)
    {
        const auto length = value<std::uint32_t>(what);
        if (length > longest || length > left()) {
            throw InputError(fmt::format("{} has a length of {}, which is impossible", what, length));
        }
        std::string result(length, '\0');
        read(result.data(), length, what);
        return result;
    }
    void seek(std::uint64_t offset)
    {
        mStream.seekg(std::streamoff(offset));
        if (!mStream) throw InputError("it cannot be read");
        mAt = offset;
    }
    void skip(std::uint64_t count, const char* what)
    {
        if (count > left()) throw InputError(fmt::format("it ends too early, in {}", what));
        seek(mAt + count);
    }

  private:
    std::istream& mStream;
    std::uint64_t mAt = 0, mEnd;
};

/// Visit all metadata. visit(name, type, size) may read the value.
template<typename Visit>
void readMetadata(Cursor& cursor, const Visit& visit)
{
    constexpr std::uint64_t kLeast = 12; // three empty strings
    const auto count = cursor.value<std::uint32_t>("the metadata");
    if (count > cursor.left() / kLeast) throw InputError(fmt::format("it says to have {} metadata", count));
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::string name = cursor.text(kLongestName, "a metadata name");
        const std::string type = cursor.text(kLongestName, "a metadata type");
        const auto size = cursor.value<std::uint32_t>("the metadata");
        const auto* fixed = std::find_if(kFixedSizes.begin(), kFixedSizes.end(),
                                         [&](const FixedSize& known) { return known.type == type; });
        if (size > cursor.left() || (fixed != kFixedSizes.end() && fixed->bytes != size)) {
            throw InputError(fmt::format("the metadata '{}' have a size of {}, which is impossible", name, size));
        }
        const std::uint64_t after = cursor.at() + size;
        visit(name, type, size);
        cursor.seek(after);
    }
}

/// Check the part of a grid before its tree. @return the memory the grid takes, as stated by its writer
std::uint64_t readGridHead(Cursor& cursor, std::uint32_t version)
{
    if (version >= kNodeMaskCompression) {
        const auto flags = cursor.value<std::uint32_t>("a grid's compression");
        if (flags > kCompressionFlags) throw InputError(fmt::format("a grid's compression is {:#x}", flags));
    }
    std::int64_t memory = 0;
    readMetadata(cursor, [&](const std::string& name, const std::string& type, std::uint32_t) {
        if (name == "file_mem_bytes" && type == "int64") memory = cursor.value<std::int64_t>("the metadata");
    });
    const std::string transform = cursor.text(kLongestName, "a transform's type");
    if (std::find(kTransforms.begin(), kTransforms.end(), transform) == kTransforms.end()) {
        throw InputError(fmt::format("a transform is of the type '{}', which there is not", transform));
    }
    return std::uint64_t(std::max<std::int64_t>(memory, 0));
}

VdbLayout::Grid readGrid(Cursor& cursor, std::uint32_t version, bool seekable, std::uint64_t size)
{
    VdbLayout::Grid grid;
    grid.begin = cursor.at();
    grid.name = cursor.text(kLongestName, "a grid's name");
    grid.name.resize(
        std::min(grid.name.find('\x1e'), grid.name.size())); // a number follows in the names of equal grids
    grid.type = cursor.text(kLongestName, "a grid's type");
    const std::string parent = cursor.text(kLongestName, "the name of a grid's instance");
    const auto head = cursor.value<std::int64_t>("a grid's offsets");
    const auto blocks = cursor.value<std::int64_t>("a grid's offsets");
    const auto end = cursor.value<std::int64_t>("a grid's offsets");
    if (seekable) {
        const auto here = std::int64_t(cursor.at());
        if (here <= head && head <= blocks && blocks <= end && std::uint64_t(end) > size) {
            throw InputError(
                fmt::format("it is truncated: it has {} bytes, and grid '{}' ends at {}; copy or write it again", size,
                            grid.name, end));
        }
        if (!(here <= head && head <= blocks && blocks <= end && std::uint64_t(end) <= size)) {
            throw InputError(
                fmt::format("the offsets {}, {}, {} of grid '{}' at {} do not lie in order in its {} bytes", head,
                            blocks, end, grid.name, here, size));
        }
        cursor.seek(std::uint64_t(head));
        grid.end = std::uint64_t(end);
    }
    grid.memory = readGridHead(cursor, version);
    if (seekable && cursor.at() > std::uint64_t(end)) {
        throw InputError(fmt::format("grid '{}' ends in its transform", grid.name));
    }
    return grid;
}

} // namespace

VdbLayout readLayout(std::istream& stream, std::uint64_t size)
{
    Cursor cursor(stream, size);
    cursor.seek(0);
    VdbLayout layout;
    if (size < sizeof kMagic || cursor.value<std::int64_t>("the magic number") != kMagic) {
        throw InputError("it is no .vdb file");
    }
    const auto version = cursor.value<std::uint32_t>("the header");
    if (version < kFirstVersion || version > kLastVersion) {
        throw InputError(
            fmt::format("it has the format version {}; {} to {} can be read", version, kFirstVersion, kLastVersion));
    }
    cursor.skip(2 * sizeof(std::uint32_t), "the header"); // the library's version
    layout.seekable = cursor.value<char>("the header") != 0;
    if (version >= kSelectiveCompression && version < kNodeMaskCompression) cursor.skip(1, "the header");
    layout.identity.resize(VdbLayout::kIdentityLength);
    cursor.read(layout.identity.data(), layout.identity.size(), "the header");
    readMetadata(cursor, [&](const std::string& name, const std::string& type, std::uint32_t length) {
        if (name != "checksum" || type != "string") return;
        layout.checksum.offset = cursor.at();
        layout.checksum.text.resize(length);
        cursor.read(layout.checksum.text.data(), length, "the metadata");
    });

    constexpr std::uint64_t kLeastGrid = 3 * sizeof(std::uint32_t) + 3 * sizeof(std::int64_t);
    const auto count = cursor.value<std::int32_t>("the number of grids");
    if (count < 0 || std::uint64_t(count) > cursor.left() / kLeastGrid) {
        throw InputError(fmt::format("it says to have {} grids", count));
    }
    layout.headerEnd = cursor.at();
    if (!layout.seekable) {
        if (count > 0) (void)readGrid(cursor, version, false, size);
        return layout;
    }
    for (std::int32_t i = 0; i < count; ++i) {
        layout.grids.push_back(readGrid(cursor, version, true, size));
        cursor.seek(layout.grids.back().end);
    }
    return layout;
}

} // namespace vdblic
