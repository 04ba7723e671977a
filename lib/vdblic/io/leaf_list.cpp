#include "vdblic/io/leaf_list.h"

namespace vdblic {

#if VDBLIC_HAS_LEAF_LIST
void insertLeafList(openvdb::MetaMap& grid, const StoredLeaves& leaves)
{
    openvdb::io::DelayedLoadMetadata list;
    list.resizeMask(leaves.kinds.size());
    list.resizeCompressedSize(leaves.sizes.size());
    for (std::size_t i = 0; i < leaves.kinds.size(); ++i)
        list.setMask(i, leaves.kinds[i]);
    for (std::size_t i = 0; i < leaves.sizes.size(); ++i)
        list.setCompressedSize(i, leaves.sizes[i]);
    grid.removeMeta(openvdb::GridBase::META_FILE_DELAYED_LOAD); // may be of another type
    grid.insertMeta(openvdb::GridBase::META_FILE_DELAYED_LOAD, list);
}

std::vector<std::uint64_t> listedLengths(const openvdb::Metadata* stored, const LeafFormat& format, std::size_t leaves,
                                         std::uint64_t bytes)
{
    const auto* given = dynamic_cast<const openvdb::io::DelayedLoadMetadata*>(stored);
    if (!given || (format.compression & LeafFormat::kCompressed) == 0) return {};
    openvdb::io::DelayedLoadMetadata list(*given);
    list.resizeMask(leaves); // OpenVDB aborts on a list that is too short
    list.resizeCompressedSize(leaves);
    constexpr std::int64_t kSize = sizeof(std::int64_t); // counted even without values; half floats then lack it
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
#else
void insertLeafList(openvdb::MetaMap&, const StoredLeaves&) {}

std::vector<std::uint64_t> listedLengths(const openvdb::Metadata*, const LeafFormat&, std::size_t, std::uint64_t)
{
    return {};
}
#endif

} // namespace vdblic
