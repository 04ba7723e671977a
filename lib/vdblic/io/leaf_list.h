#pragma once

#include "vdblic/io/leaf_record.h"
#include "vdblic/io/vdb_assembly.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// OpenVDB's list of a grid's leaves, a metadata entry of the grid: their kinds, and the sizes of their values. It
/// serves delayed loading; an OpenVDB without delayed loading has no list. Where there is one, openvdb/io/Compression.h
/// includes its header; __has_include would find that of any OpenVDB on the machine.
#ifdef OPENVDB_DELAYED_LOAD_METADATA_HAS_BEEN_INCLUDED
#define VDBLIC_HAS_LEAF_LIST true
#else
#define VDBLIC_HAS_LEAF_LIST false
#endif
inline constexpr bool kHasLeafList = VDBLIC_HAS_LEAF_LIST;

/// Add the list to a grid's metadata.
void insertLeafList(openvdb::MetaMap& grid, const StoredLeaves& leaves);

/// The lengths of all records, from the list.
/// @param list nullptr if there is none  @param bytes of all records
/// @return nothing if there is no list, or it is inconsistent
[[nodiscard]] std::vector<std::uint64_t> listedLengths(const openvdb::Metadata* list, const LeafFormat& format,
                                                       std::size_t leaves, std::uint64_t bytes);

} // namespace vdblic
