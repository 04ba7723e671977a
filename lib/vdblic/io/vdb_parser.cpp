#include "vdblic/io/vdb_parser.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/hazard.h"
#include "vdblic/io/leaf_list.h"
#include "vdblic/io/leaf_record.h"
#include "vdblic/io/node_places.h"
#include "vdblic/io/vdb_archive.h"

#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <istream>
#include <streambuf>
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

/// The settings that OpenVDB keeps on a stream and needs to parse leaves.
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

void passOver(std::istream& stream, std::uint64_t bytes)
{
    constexpr std::uint64_t kWorthSeeking = 1 << 16; // a stream's buffer is read anew after it
    bytes < kWorthSeeking ? stream.ignore(std::streamsize(bytes)) : stream.seekg(std::streamoff(bytes), std::ios::cur);
}

/// Reads grids as OpenVDB's readGrid() does, but their leaves by all threads.
class LeafwiseArchive : public VdbArchive {
  public:
    LeafwiseArchive(const std::filesystem::path& path, std::uint64_t size, const LeafFilter& isKept)
        : mPath(path), mSize(size), mIsKept(isKept)
    {
    }

    VdbFile read(std::istream& stream)
    {
        readAnyHeader(stream);
        vdb_io::setVersion(stream, libraryVersion(), fileVersion());
        vdb_io::setDataCompression(stream, compression());
        VdbFile file;
        file.path = mPath;
        file.metadata.readMeta(stream);
        std::vector<vdb_io::GridDescriptor> descriptors(std::size_t(readGridCount(stream)));
        NamedGridMap named;
        for (vdb_io::GridDescriptor& descriptor : descriptors) {
            const openvdb::GridBase::Ptr grid = readDescriptor(descriptor, stream);
            readGrid(*grid, descriptor, stream);
            file.grids.push_back(grid);
            named[descriptor.uniqueName()] = grid;
        }
        for (const vdb_io::GridDescriptor& descriptor : descriptors)
            connectInstance(descriptor, named);
        return file;
    }

  private:
    static constexpr std::size_t kBatchBytes = std::size_t(1) << 18, kRecordBytes = std::size_t(1) << 14;

    void readGrid(openvdb::GridBase& grid, const vdb_io::GridDescriptor& descriptor, std::istream& stream) const
    {
        readGridCompression(stream);
        vdb_io::StreamMetadata::Ptr settings(new vdb_io::StreamMetadata(stream)); // of this grid alone
        vdb_io::setStreamMetadataPtr(stream, settings, /*transfer=*/false);
        grid.readMeta(stream);
        const openvdb::Metadata::ConstPtr list = grid[openvdb::GridBase::META_FILE_DELAYED_LOAD];
        grid.removeMeta(openvdb::GridBase::META_FILE_DELAYED_LOAD);
        if (fileVersion() < openvdb::OPENVDB_FILE_VERSION_NO_GRIDMAP) grid.setName(descriptor.gridName());
        grid.readTransform(stream);
        if (!descriptor.isInstance()) {
            grid.readTopology(stream);
            const auto bytes = std::uint64_t(descriptor.getEndPos() - descriptor.getBlockPos());
            const bool leafwise =
                fileVersion() >= openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION &&
                grid.apply<LeafwiseGrids>([&](auto& typed) { readLeaves(typed, list.get(), bytes, stream); });
            if (!leafwise) grid.readBuffers(stream);
            if (!hasNodesInPlace(grid))
                throw InputError(fmt::format("nodes of grid '{}' do not lie in their places", descriptor.gridName()));
        }
        vdb_io::clearStreamMetadataPtr(stream);
    }

    /// @param list of the leaves; nullptr if there is none  @param bytes that all leaves take in the file
    template<typename GridT>
    void readLeaves(GridT& grid, const openvdb::Metadata* list, std::uint64_t bytes, std::istream& stream) const
    {
        const StreamSettings settings(stream);
        const bool half = grid.saveFloatAsHalf();
        const LeafFormat format = LeafFormat::of<typename GridT::ValueType>(settings.compression, half);
        std::vector<typename GridT::TreeType::LeafNodeType*> leaves;
        leaves.reserve(grid.tree().leafCount());
        grid.tree().getNodes(leaves);

        const auto isKept = [&](std::size_t leaf) { return !mIsKept || mIsKept(grid, leaves[leaf]->origin()); };
        const bool listed = mIsKept && libraryVersion().first > 6; // before 6.2 the list might be another grid's
        const std::vector<std::uint64_t> lengths =
            listed ? listedLengths(list, format, leaves.size(), bytes) : std::vector<std::uint64_t>();
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
                appendLeafRecord(stream, format, mSize, isKept(next) ? batch.bytes : unused);
            }
            if (next == leaves.size()) passOver(stream, std::exchange(passed, 0));
            return batch;
        };
        const auto parse = [&](LeafBatch batch) {
            const Hazard parsing(mPath.string(), mSize);
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

    const std::filesystem::path& mPath;
    std::uint64_t mSize;
    const LeafFilter& mIsKept;
};

} // namespace

VdbFile parseVdb(std::istream& stream, const std::filesystem::path& path, std::uint64_t size, const LeafFilter& isKept)
{
    return LeafwiseArchive(path, size, isKept).read(stream);
}

} // namespace vdblic
