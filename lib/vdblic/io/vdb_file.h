#pragma once

#include "vdblic/core/errors.h"
#include "vdblic/core/names.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace vdblic {

/// The grids and the file metadata of one .vdb file.
struct VdbFile {
    openvdb::GridPtrVec grids;
    openvdb::MetaMap metadata;
    std::filesystem::path path; ///< for messages

    /// The first grid of a name and type, or null. openvdb::GridBase stands for any type.
    template<typename GridT>
    [[nodiscard]] typename GridT::Ptr find(std::string_view name) const
    {
        for (const openvdb::GridBase::Ptr& grid : grids) {
            if (grid->getName() != name) continue;
            if constexpr (std::is_same_v<GridT, openvdb::GridBase>) {
                return grid;
            } else if (auto typed = openvdb::gridPtrCast<GridT>(grid)) {
                return typed;
            }
        }
        return nullptr;
    }

    /// The first grid of a name and type, as find().
    /// @param choice how to name another grid, for the message; may be empty
    /// @throws InputError, as missing() makes it, if there is none
    template<typename GridT>
    [[nodiscard]] typename GridT::Ptr get(std::string_view name, std::string_view choice = {}) const
    {
        if (auto grid = find<GridT>(name)) return grid;
        std::string type;
        if constexpr (!std::is_same_v<GridT, openvdb::GridBase>) {
            type = std::string(openvdb::typeNameAsString<typename GridT::ValueType>()) + ' ';
        }
        throw missing(fmt::format("{}grid '{}'", type, name), choice);
    }

    /// An error for what the file lacks: "PATH: no WHAT; present: CONTENTS; choose with CHOICE".
    [[nodiscard]] InputError missing(std::string_view what, std::string_view choice = {}) const;

    /// The names and types in the file, for messages: "density (float), velocity (vec3s)".
    [[nodiscard]] std::string contents() const;
};

/// Chooses leaves of a grid by their first voxels. Called by several threads at a time.
using LeafFilter = std::function<bool(const openvdb::GridBase& grid, const openvdb::Coord& origin)>;

/// Read a whole file, without delayed loading. All volumes are read by this function (docs/architecture.md).
///
/// Before OpenVDB parses the file, these are checked: the header, the checksums if there are any, and the memory that
/// the grids need. HazardHooks cover crashes of OpenVDB on hostile bytes that pass these checks.
/// @param isKept whether a leaf gets its values. Other leaves have none (LeafBuffer::empty()); long runs of them are
/// skipped by OpenVDB's list of leaf sizes. Grids of points, bool and masks are read whole
/// @param verify whether checksums are checked, which reads all bytes
/// @throws InputError naming the file and the reason
[[nodiscard]] VdbFile readVdb(const std::filesystem::path& path, const LeafFilter& isKept = {}, bool verify = true);

/// Let the system read a file into its cache, outside the process's memory. Returns at once; readVdb() reports errors.
void cacheFile(const std::filesystem::path& path);

/// Check a file's header and checksums without reading its grids.
/// @return whether it has checksums. @throws InputError naming the file and the damaged grid
bool verifyVdb(const std::filesystem::path& path);

/// How the leaves of a file are compressed.
enum class VdbCompression { kBlosc, kNone };
template<>
inline constexpr auto kNames<VdbCompression> = std::to_array<std::string_view>({"blosc", "none"});

/// Write grids and file metadata atomically, and add `creator` and `checksum`. Equal content gives equal files.
/// @throws OutputError naming the file and the reason, such as a full disk; std::bad_alloc
void writeVdb(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata,
              VdbCompression compression = VdbCompression::kBlosc);

class LeafSource;
/// writeVdb() of grids whose leaves are stored already. @param source of the leaves of the first grids, or null
/// @throws exceptions of the source that are no std::exception
void writeStoredVdb(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids,
                    const openvdb::MetaMap& metadata, VdbCompression compression, LeafSource* source);

/// A number stored as double, float, int32 or int64 metadata, if there is one.
[[nodiscard]] std::optional<double> numericMetadata(const openvdb::MetaMap& metadata, const std::string& name);

} // namespace vdblic
