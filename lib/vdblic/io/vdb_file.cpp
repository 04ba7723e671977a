#include "vdblic/io/vdb_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/extent.h"
#include "vdblic/core/hazard.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/printable.h"
#include "vdblic/core/version.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/checksum.h"
#include "vdblic/io/guarded_buffer.h"
#include "vdblic/io/input_file.h"
#include "vdblic/io/invertible.h"
#include "vdblic/io/vdb_assembly.h"
#include "vdblic/io/vdb_header.h"
#include "vdblic/io/vdb_layout.h"
#include "vdblic/io/vdb_parser.h"

#include <fcntl.h>
#include <openvdb/io/Compression.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <fstream>
#include <new>
#include <system_error>
#include <vector>

namespace vdblic {
namespace {

/// A message of OpenVDB made printable and short: it may quote damaged bytes of a file.
std::string clamped(std::string message)
{
    message = printable(message);
    constexpr std::size_t kLongest = 200;
    if (message.size() > kLongest) {
        message.resize(kLongest);
        message += "...";
    }
    return message;
}

void initializeOnce()
{
    static const bool done = (openvdb::initialize(), true);
    (void)done;
}

std::uint32_t compressionFlags(VdbCompression compression)
{
    namespace io = openvdb::io;
    return io::COMPRESS_ACTIVE_MASK | (compression == VdbCompression::kBlosc ? io::COMPRESS_BLOSC : io::COMPRESS_NONE);
}

/// Refuse singular transforms, and voxels beyond kFarthestIndex.
void checkPlaces(const VdbFile& file)
{
    for (const openvdb::GridBase::Ptr& grid : file.grids) {
        if (!grid->transform().isLinear() || isInvertible(grid->transform())) continue;
        throw InputError(fmt::format("{}: grid '{}' has a transform that flattens space, or is not finite; give its "
                                     "voxels a size",
                                     file.path.string(), grid->getName()));
    }
    const openvdb::CoordBBox all(openvdb::Coord(-kFarthestIndex), openvdb::Coord(kFarthestIndex));
    for (const openvdb::GridBase::Ptr& grid : file.grids) {
        openvdb::CoordBBox nodes;
        grid->baseTree().getIndexRange(nodes);
        if (nodes.empty() || all.isInside(nodes)) continue;
        const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
        if (box.empty() || all.isInside(box)) continue;
        throw InputError(fmt::format("{}: grid '{}': active voxels reach from [{} {} {}] to [{} {} {}]; indices "
                                     "beyond ±{} cannot be used: move the grid's origin or cut it",
                                     file.path.string(), grid->getName(), box.min()[0], box.min()[1], box.min()[2],
                                     box.max()[0], box.max()[1], box.max()[2], kFarthestIndex));
    }
}

/// Overwrite the placeholders of the checksums and of the identity.
void stampChecksums(std::fstream& file)
{
    file.seekg(0, std::ios::end);
    const VdbLayout layout = readLayout(file, std::uint64_t(file.tellg()));
    const std::string checksums = computeChecksums(file, layout);
    file.seekp(std::streamoff(layout.checksum.offset));
    file << checksums;
    file.seekp(std::streamoff(VdbLayout::kIdentityOffset));
    file << identityOf(checksums);
}

/// An open file whose header and checksums, if it has any, were checked.
class GuardedFile {
  public:
    explicit GuardedFile(const std::filesystem::path& path, bool verify = true)
        : mPath(path), mMemory(std::size_t(1) << 16)
    {
        std::error_code error;
        if (!std::filesystem::exists(path, error)) throw InputError(fmt::format("{}: no such file", path.string()));
        checkRegular(path);
        try {
            mBuffer.pubsetbuf(mMemory.data(), std::streamsize(mMemory.size()));
            errno = 0;
            const bool open = mBuffer.open(path, std::ios::in | std::ios::binary) != nullptr;
            mSize = std::filesystem::file_size(path, error);
            if (!open || error) throw InputError(std::generic_category().message(errno));
            mLayout = readLayout(mStream, mSize);
            mHasChecksums = vdblic::hasChecksums(mLayout);
            if (mHasChecksums && verify) verifyChecksums(mStream, mLayout, mSize);
        } catch (const InputError& reason) {
            fail(reason.what());
        }
    }

    [[nodiscard]] bool hasChecksums() const { return mHasChecksums; }

    [[nodiscard]] VdbFile read(const LeafFilter& isKept)
    {
        if (!isKept) {
            double memory = 0;
            for (const VdbLayout::Grid& grid : mLayout.grids)
                memory += double(grid.memory);
            constexpr double kMostCompressed = 256; // a damaged file may announce anything
            const bool canBeTrue = memory <= kMostCompressed * double(mSize);
            if (!canBeTrue || !paging::mayHold(memory)) checkMemory(memory, mPath.string(), "take a smaller file");
            if (canBeTrue) paging::expectFiles(memory);
        }
        initializeOnce();
        const Hazard parsing(mPath.string(), mSize);
        // The stream throws: OpenVDB would take the remains of a failed read for data and might loop for hours.
        mStream.exceptions(std::ios::failbit | std::ios::badbit);
        try {
            mStream.seekg(0);
            mBuffer.guard(mStream, mLayout);
            VdbFile file = parseVdb(mStream, mPath, mSize, isKept);
            removeForeignMetadata(file.grids);
            return file;
        } catch (const std::ios::failure& failure) {
            fail(mStream.eof()                            ? "it ends too early"
                 : failure.code() != std::io_errc::stream ? failure.code().message()
                                                          : "it is damaged");
        } catch (const std::bad_alloc&) {
            paging::checkScratch();
            fail(fmt::format("it is damaged, or takes more than the {} of memory that may be used: {}",
                             memoryText(double(memoryLimit())), memoryMend()));
        } catch (const std::exception& e) {
            fail(e.what());
        }
    }

  private:
    [[noreturn]] void fail(const std::string& reason) const
    {
        throw InputError(fmt::format("{}: cannot be read as a .vdb file: {}", mPath.string(), clamped(reason)));
    }

    std::filesystem::path mPath;
    std::vector<char> mMemory; // of mBuffer
    GuardedBuffer mBuffer;
    std::istream mStream{&mBuffer};
    std::uint64_t mSize = 0;
    VdbLayout mLayout;
    bool mHasChecksums = false;
};

} // namespace

InputError VdbFile::missing(std::string_view what, std::string_view choice) const
{
    return InputError{fmt::format("{}: no {}; present: {}{}{}", path.string(), what, contents(),
                                  choice.empty() ? "" : "; choose with ", choice)};
}

std::string VdbFile::contents() const
{
    std::string text;
    for (const openvdb::GridBase::Ptr& grid : grids) {
        text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", grid->getName(), grid->valueType());
    }
    return text.empty() ? "no grids" : clamped(text);
}

VdbFile readVdb(const std::filesystem::path& path, const LeafFilter& isKept, bool verify)
{
    VdbFile file = GuardedFile(path, verify).read(isKept);
    checkPlaces(file);
    file.metadata.removeMeta("checksum"); // describes the bytes on disk, not the result
    return file;
}

void cacheFile(const std::filesystem::path& path)
{
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) return;
    const ::off_t size = ::lseek(file, 0, SEEK_END);
    constexpr ::off_t kPart = 1 << 20; // of a longer part Linux reads the beginning
    for (::off_t begin = 0; begin < size; begin += kPart)
        (void)::posix_fadvise(file, begin, kPart, POSIX_FADV_WILLNEED);
    ::close(file);
}

bool verifyVdb(const std::filesystem::path& path)
{
    return GuardedFile(path).hasChecksums();
}

void writeVdb(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata,
              VdbCompression compression)
{
    writeStoredVdb(path, grids, metadata, compression, nullptr);
}

template<typename GridT>
StoredLeaves storeLeaves(const GridT& grid, const std::vector<const typename GridT::TreeType::LeafNodeType*>& leaves,
                         VdbCompression compression)
{
    return VdbAssembly(compressionFlags(compression)).store(grid, leaves);
}
template StoredLeaves storeLeaves(const openvdb::FloatGrid&,
                                  const std::vector<const openvdb::FloatTree::LeafNodeType*>&, VdbCompression);
template StoredLeaves storeLeaves(const openvdb::Int32Grid&,
                                  const std::vector<const openvdb::Int32Tree::LeafNodeType*>&, VdbCompression);

void writeStoredVdb(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& given,
                    VdbCompression compression, LeafSource* source)
{
    initializeOnce();
    openvdb::MetaMap metadata = given;
    metadata.removeMeta("creator");
    metadata.insertMeta("creator", openvdb::StringMetadata(kCreator));
    metadata.removeMeta("checksum");
    metadata.insertMeta("checksum", openvdb::StringMetadata(emptyChecksums(grids.size())));
    AtomicFile output(path);
    errno = 0;
    try {
        std::fstream stream;
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        stream.open(output.temporary(), std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
        VdbAssembly(compressionFlags(compression)).assemble(stream, grids, metadata, source);
        stampChecksums(stream);
        stream.close();
    } catch (const std::bad_alloc&) {
        throw; // lack of memory, no failure of the disk
    } catch (const std::exception& e) {
        // The exception of a stream has no reason; errno has.
        const std::string reason = errno != 0 ? std::generic_category().message(errno) : clamped(e.what());
        throw OutputError(fmt::format("{}: cannot be written: {}", path.string(), reason));
    }
    output.commit();
}

std::optional<double> numericMetadata(const openvdb::MetaMap& metadata, const std::string& name)
{
    const openvdb::Metadata::ConstPtr value = metadata[name];
    if (!value) return std::nullopt;
    if (const auto* d = dynamic_cast<const openvdb::DoubleMetadata*>(value.get())) return d->value();
    if (const auto* f = dynamic_cast<const openvdb::FloatMetadata*>(value.get())) return double(f->value());
    if (const auto* i = dynamic_cast<const openvdb::Int32Metadata*>(value.get())) return double(i->value());
    if (const auto* l = dynamic_cast<const openvdb::Int64Metadata*>(value.get())) return double(l->value());
    return std::nullopt;
}

} // namespace vdblic
