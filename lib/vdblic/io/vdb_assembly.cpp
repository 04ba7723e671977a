#include "vdblic/io/vdb_assembly.h"

#include "vdblic/core/paging.h"
#include "vdblic/io/leaf_list.h"
#include "vdblic/io/leaf_record.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <ostream>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

namespace vdb_io = openvdb::io;

constexpr std::size_t kLeavesPerBlock = 256;

/// @param stored compression flags of the grid: without zip for fog volumes and level sets
/// @param listed flags by which OpenVDB makes its list
template<typename GridT, typename Leaf>
StoredLeaves storeLeaves(const GridT& grid, const std::vector<const Leaf*>& leaves, std::uint32_t stored,
                         std::uint32_t listed)
{
    const bool half = grid.saveFloatAsHalf(), sizes = kHasLeafList && (listed & LeafFormat::kCompressed) != 0;
    const LeafFormat format = LeafFormat::of<typename GridT::ValueType>(stored, half);

    StoredLeaves result;
    result.lengths.resize(leaves.size());
    result.kinds.resize(leaves.size());
    if (sizes) result.sizes.resize(leaves.size());
    result.blocks.resize((leaves.size() + kLeavesPerBlock - 1) / kLeavesPerBlock);
    tbb::parallel_for(std::size_t(0), result.blocks.size(), [&](std::size_t block) {
        std::ostringstream stream;
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        vdb_io::setDataCompression(stream, stored);
        vdb_io::setGridBackgroundValuePtr(stream, &grid.background());
        const std::size_t first = block * kLeavesPerBlock;
        const std::size_t last = std::min(first + kLeavesPerBlock, leaves.size());
        for (std::size_t i = first; i < last; ++i) {
            paging::breathe(Leaf::SIZE * sizeof(typename Leaf::ValueType));
            const auto begin = std::size_t(stream.tellp());
            leaves[i]->writeBuffers(stream, half);
            const std::string_view record = stream.view().substr(begin);
            const auto kind = static_cast<signed char>(record[LeafFormat::kMaskBytes]);
            result.lengths[i] = std::uint32_t(record.size());
            result.kinds[i] = kind;
            if (!sizes) continue;
            // The list counts 8 bytes for the size, even without values.
            constexpr std::size_t kSize = sizeof(std::int64_t);
            const std::size_t size =
                stored == listed
                    ? std::max(kSize, record.size() - format.headBytes(kind))
                    : kSize + vdb_io::writeCompressedValuesSize(leaves[i]->buffer().data(), Leaf::SIZE,
                                                                leaves[i]->valueMask(), kind, half, listed);
            result.sizes[i] = std::int64_t(size);
        }
        result.blocks[block] = std::move(stream).str();
    });
    return result;
}

template<typename GridT>
StoredLeaves storeLeaves(const GridT& grid, std::uint32_t stored, std::uint32_t listed)
{
    std::vector<const typename GridT::TreeType::LeafNodeType*> leaves;
    leaves.reserve(grid.tree().leafCount());
    grid.tree().getNodes(leaves);
    return storeLeaves(grid, leaves, stored, listed);
}

} // namespace

/// The compression flags of a grid, by its class.
std::uint32_t VdbAssembly::flagsOf(const openvdb::GridBase& grid) const
{
    std::ostringstream scratch;
    setGridCompression(scratch, grid);
    return vdb_io::getDataCompression(scratch);
}

template<typename GridT>
StoredLeaves VdbAssembly::store(const GridT& grid,
                                const std::vector<const typename GridT::TreeType::LeafNodeType*>& leaves) const
{
    return storeLeaves(grid, leaves, flagsOf(grid), compression());
}
template StoredLeaves VdbAssembly::store(const openvdb::FloatGrid&,
                                         const std::vector<const openvdb::FloatTree::LeafNodeType*>&) const;
template StoredLeaves VdbAssembly::store(const openvdb::Int32Grid&,
                                         const std::vector<const openvdb::Int32Tree::LeafNodeType*>&) const;

void VdbAssembly::assemble(std::ostream& stream, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata,
                           LeafSource* source) const
{
    vdb_io::StreamMetadata::Ptr settings(new vdb_io::StreamMetadata);
    vdb_io::setStreamMetadataPtr(stream, settings, /*transfer=*/false);
    vdb_io::setWriteGridStatsMetadata(stream, true);
    writeHeader(stream, /*seekable=*/true);
    metadata.writeMeta(stream);
    const auto count = std::int32_t(grids.size());
    stream.write(reinterpret_cast<const char*>(&count), sizeof count);

    std::map<std::string, int> names;
    for (const openvdb::GridBase::ConstPtr& grid : grids)
        ++names[grid->getName()];
    std::set<std::string> used;
    std::map<const openvdb::TreeBase*, vdb_io::GridDescriptor> written;
    std::size_t number = 0;
    for (const openvdb::GridBase::ConstPtr& grid : grids) {
        // Grids without a name, and those of one name, are numbered.
        const std::string name = grid->getName();
        std::string unique = name.empty() || names[name] > 1 ? vdb_io::GridDescriptor::addSuffix(name, 0) : name;
        for (int n = 1; !used.insert(unique).second; ++n)
            unique = vdb_io::GridDescriptor::addSuffix(name, n);
        vdb_io::GridDescriptor descriptor(unique, grid->type(), grid->saveFloatAsHalf());

        vdb_io::setDataCompression(stream, compression());
        const auto same = written.find(&grid->baseTree());
        if (same != written.end() && same->second.saveFloatAsHalf() == grid->saveFloatAsHalf()) {
            descriptor.setInstanceParentName(same->second.uniqueName());
            writeGridInstance(descriptor, grid, stream, /*seekable=*/true);
        } else {
            writeGrid(descriptor, grid, source && number < source->grids() ? source : nullptr, stream);
            written[&grid->baseTree()] = descriptor;
        }
        ++number;
    }
}

void VdbAssembly::writeGrid(vdb_io::GridDescriptor& descriptor, const openvdb::GridBase::ConstPtr& grid,
                            LeafSource* source, std::ostream& stream) const
{
    const std::uint32_t flags = flagsOf(*grid);
    StoredLeaves leaves;
    if (source) {
        leaves = source->leaves();
    } else if (!grid->apply<LeafwiseGrids>(
                   [&](const auto& typed) { leaves = storeLeaves(typed, flags, compression()); })) {
        Archive::writeGrid(descriptor, grid, stream, /*seekable=*/true);
        return;
    }
    descriptor.writeHeader(stream);
    const std::streampos offsets = stream.tellp();
    descriptor.writeStreamPos(stream); // not known yet
    descriptor.setGridPos(stream.tellp());
    setGridCompression(stream, *grid);
    const auto head = openvdb::ConstPtrCast<openvdb::GridBase>(grid->copyGrid()); // of the same tree
    insertLeafList(*head, leaves);
    const std::size_t nodes = grid->memUsage(); // before statistics, for which OpenVDB 12.1 allocates values
    head->addStatsMetadata();
    if (source) { // OpenVDB's figure includes values, which these nodes lack
        static_assert(sizeof(float) == sizeof(std::int32_t)); // of the grids that store() takes
        const std::size_t values = leaves.kinds.size() * LeafFormat::kVoxels * sizeof(float);
        head->insertMeta(openvdb::GridBase::META_FILE_MEM_BYTES, openvdb::Int64Metadata(std::int64_t(nodes + values)));
    }
    head->removeMeta(openvdb::GridBase::META_FILE_COMPRESSION); // may be of another type
    head->insertMeta(openvdb::GridBase::META_FILE_COMPRESSION,
                     openvdb::StringMetadata(vdb_io::compressionToString(flags)));
    head->writeMeta(stream);
    grid->writeTransform(stream);
    grid->writeTopology(stream);
    descriptor.setBlockPos(stream.tellp());
    for (std::string& block : leaves.blocks) {
        stream.write(block.data(), std::streamsize(block.size()));
        block = {};
    }
    for (std::string block; source && !(block = source->block()).empty();)
        stream.write(block.data(), std::streamsize(block.size()));
    descriptor.setEndPos(stream.tellp());
    stream.seekp(offsets);
    descriptor.writeStreamPos(stream);
    descriptor.seekToEnd(stream);
}

} // namespace vdblic
