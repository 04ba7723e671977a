#pragma once

#include "vdblic/io/vdb_file.h"

#include <cstdint>
#include <filesystem>
#include <iosfwd>

namespace vdblic {

/// Parse a .vdb file as openvdb::io::Stream does, but decompress leaves in parallel.
///
/// One thread at a time cuts the stream into the records of leaves; it checks each record's sizes against those of its
/// values. OpenVDB parses batches of records in all threads. Points, bool and mask grids, and files older than version
/// 222 are left to OpenVDB.
/// @param stream at the file's begin; throws at its end  @param size of the file in bytes
/// @param isKept as that of readVdb()
/// @throws InputError with the reason, but not the file; what the stream and OpenVDB throw
[[nodiscard]] VdbFile parseVdb(std::istream& stream, const std::filesystem::path& path, std::uint64_t size,
                               const LeafFilter& isKept = {});

} // namespace vdblic
