#include "vdblic/io/vdb_parser.h"

#include "vdblic/core/hazard.h"
#include "vdblic/io/leaf_record.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/DelayedLoadMetadata.h>
#include <openvdb/io/GridDescriptor.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <istream>
#include <memory>
#include <streambuf>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

namespace vdb_io = openvdb::io;

/// A stream buffer over bytes in memory.
class MemoryBuffer : public std::streambuf {
  public:
    explicit MemoryBuffer(std::vector<char>& bytes) { setg(bytes.data(), bytes.data(), bytes.data() + bytes.size()); }
};

/// Consecutive leaves of a grid, as they are stored.
struct LeafBatch {
    std::size_t begin = 0, end = 0; ///< among the grid's leaves
    std::vector<char> bytes;
};

/// What OpenVDB keeps on a stream and needs to parse leaves.
struct StreamSettings {
    openvdb::VersionId library;
    std::uint32_t format = 0, compression = 0;
    const void* background = nullptr;

    explicit StreamSettings(std::istream& stream)
        : library(vdb_io::getLibraryVersion(stream)), format(vdb_io::getFormatVersion(stream)),
          compression(vdb_io::getDataCompression(stream)), background(vdb_io::getGridBackgroundValuePtr(stream))
    {
    }
    void giveTo(std::istream& stream) const
    {
        vdb_io::setVersion(stream, library, format);
        vdb_io::setDataCompression(stream, compression);
        vdb_io::setGridBackgroundValuePtr(stream, background);
    }
};

/// The lengths of all records by OpenVDB's list of them.
/// @param bytes that all records take  @return nothing if there is no list, or it does not add up
std::vector<std::uint64_t> listedLengths(std::istream& stream, const LeafFormat& format, std::size_t leaves,
                                         std::uint64_t bytes)
{
    const openvdb::MetaMap& metadata = vdb_io::getStreamMetadataPtr(stream)->gridMetadata();
    const auto stored = metadata.getMetadata<vdb_io::DelayedLoadMetadata>(openvdb::GridBase::META_FILE_DELAYED_LOAD);
    if (!stored || (format.compression & LeafFormat::kCompressed) == 0) return {};
    vdb_io::DelayedLoadMetadata list(*stored);
    list.resizeMask(leaves); // OpenVDB aborts where a list is too short
    list.resizeCompressedSize(leaves);
    constexpr std::int64_t kSize = sizeof(std::int64_t); // what the list counts for no values, which half floats lack
    std::vector<std::uint64_t> lengths(leaves);
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < leaves; ++i) {
        const std::int64_t size = list.getCompressedSize(i);
        if (size < kSize) return {};
        lengths[i] = format.headBytes(list.getMask(i)) + (format.half && size == kSize ? 0 : std::uint64_t(size));
        sum += lengths[i];
    }
    return sum == bytes ? lengths : std::vector<std::uint64_t>();
}

void passOver(std::istream& stream, std::uint64_t bytes)
{
    constexpr std::uint64_t kWorthSeeking = 1 << 16; // a stream's buffer is read anew after it
    bytes < kWorthSeeking ? stream.ignore(std::streamsize(bytes)) : stream.seekg(std::streamoff(bytes), std::ios::cur);
}

/// A grid that reads its leaves in parallel.
template<typename GridT>
class LeafwiseGrid : public GridT {
  public:
    /// @param leafBytes of the grid in the file  @param isKept as that of parseVdb(); must outlive this
    LeafwiseGrid(std::filesystem::path path, std::uint64_t fileSize, std::uint64_t leafBytes, const LeafFilter& isKept)
        : mPath(std::move(path)), mFileSize(fileSize), mLeafBytes(leafBytes), mIsKept(isKept)
    {
    }

    using GridT::readBuffers;
    void readBuffers(std::istream& stream) override
    {
        const StreamSettings settings(stream);
        if (settings.format < openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION) {
            GridT::readBuffers(stream);
            return;
        }
        const bool half = this->saveFloatAsHalf();
        const LeafFormat format = LeafFormat::of<typename GridT::ValueType>(settings.compression, half);
        std::vector<typename GridT::TreeType::LeafNodeType*> leaves;
        leaves.reserve(this->tree().leafCount());
        this->tree().getNodes(leaves);

        const auto isKept = [&](std::size_t leaf) { return !mIsKept || mIsKept(*this, leaves[leaf]->origin()); };
        const std::vector<std::uint64_t> lengths =
            mIsKept ? listedLengths(stream, format, leaves.size(), mLeafBytes) : std::vector<std::uint64_t>();
        std::vector<char> unused;
        std::size_t next = 0;
        std::uint64_t passed = 0; // bytes before the next leaf
        const auto cut = [&](tbb::flow_control& flow) {
            LeafBatch batch{next, next, {}};
            if (next == leaves.size()) flow.stop();
            batch.bytes.reserve(kBatchBytes + kRecordBytes);
            for (; next < leaves.size() && batch.bytes.size() < kBatchBytes; batch.end = ++next) {
                if (!isKept(next) && !lengths.empty()) {
                    passed += lengths[next];
                    continue;
                }
                passOver(stream, std::exchange(passed, 0));
                unused.clear();
                appendLeafRecord(stream, format, mFileSize, isKept(next) ? batch.bytes : unused);
            }
            if (next == leaves.size()) passOver(stream, std::exchange(passed, 0));
            return batch;
        };
        const auto parse = [&](LeafBatch batch) {
            const Hazard parsing(mPath.string(), mFileSize);
            MemoryBuffer buffer(batch.bytes);
            std::istream records(&buffer);
            records.exceptions(std::ios::failbit | std::ios::badbit);
            settings.giveTo(records);
            for (std::size_t i = batch.begin; i < batch.end; ++i) {
                if (isKept(i)) leaves[i]->readBuffers(records, half);
            }
        };
        const std::size_t batches = 2 * std::size_t(tbb::this_task_arena::max_concurrency());
        // A thread that waits here must not take up other work, which would count as parsing.
        tbb::this_task_arena::isolate([&] {
            tbb::parallel_pipeline(batches, tbb::make_filter<void, LeafBatch>(tbb::filter_mode::serial_in_order, cut) &
                                                tbb::make_filter<LeafBatch, void>(tbb::filter_mode::parallel, parse));
        });
    }

  private:
    static constexpr std::size_t kBatchBytes = std::size_t(1) << 18, kRecordBytes = std::size_t(1) << 14;

    std::filesystem::path mPath;
    std::uint64_t mFileSize, mLeafBytes;
    const LeafFilter& mIsKept;
};

class LeafwiseArchive : public openvdb::io::Archive {
  public:
    VdbFile read(std::istream& stream, const std::filesystem::path& path, std::uint64_t size, const LeafFilter& isKept)
    {
        readHeader(stream);
        vdb_io::StreamMetadata::Ptr settings(new vdb_io::StreamMetadata);
        vdb_io::setStreamMetadataPtr(stream, settings, /*transfer=*/false);
        vdb_io::setVersion(stream, libraryVersion(), fileVersion());
        vdb_io::setDataCompression(stream, compression());
        VdbFile file;
        file.path = path;
        file.metadata.readMeta(stream);
        std::vector<vdb_io::GridDescriptor> descriptors(std::size_t(readGridCount(stream)));
        NamedGridMap named;
        for (vdb_io::GridDescriptor& descriptor : descriptors) {
            openvdb::GridBase::Ptr grid = descriptor.read(stream), leafwise;
            const auto leafBytes = std::uint64_t(descriptor.getEndPos() - descriptor.getBlockPos());
            grid->apply<LeafwiseGrids>([&]<typename GridT>(const GridT&) {
                leafwise = std::make_shared<LeafwiseGrid<GridT>>(path, size, leafBytes, isKept);
            });
            if (leafwise) leafwise->setSaveFloatAsHalf(descriptor.saveFloatAsHalf());
            readGrid(leafwise ? leafwise : grid, descriptor, stream);
            if (leafwise) grid = leafwise->copyGrid(); // of the same tree, but of the usual type
            file.grids.push_back(grid);
            named[descriptor.uniqueName()] = grid;
        }
        for (const vdb_io::GridDescriptor& descriptor : descriptors)
            connectInstance(descriptor, named);
        return file;
    }
};

} // namespace

VdbFile parseVdb(std::istream& stream, const std::filesystem::path& path, std::uint64_t size, const LeafFilter& isKept)
{
    return LeafwiseArchive().read(stream, path, size, isKept);
}

} // namespace vdblic
