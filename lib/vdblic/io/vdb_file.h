#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace vdblic {

/// The grids and the file metadata of one .vdb file.
struct VdbFile {
    openvdb::GridPtrVec grids;
    openvdb::MetaMap metadata;

    /// The first grid of a name and type, or null.
    template<typename GridT>
    [[nodiscard]] typename GridT::Ptr find(std::string_view name) const
    {
        for (const openvdb::GridBase::Ptr& grid : grids) {
            if (grid->getName() == name) {
                if (auto typed = openvdb::gridPtrCast<GridT>(grid)) return typed;
            }
        }
        return nullptr;
    }

    /// The names and types in the file, for messages: "density (float), velocity (vec3s)".
    [[nodiscard]] std::string contents() const;
};

/// Read a whole file at once, never delayed: the one door for volumes, whoever made them (docs/survival.md).
///
/// The header is checked first, then the checksums if the file is one of ours, then whether the grids fit into memory,
/// and only then does OpenVDB see it. What OpenVDB does with hostile bytes that get so far is up to HazardHooks.
/// @throws InputError naming the file and the reason
[[nodiscard]] VdbFile readVdb(const std::filesystem::path& path);

/// Check a file's header and checksums without reading its grids.
/// @return whether it has checksums. @throws InputError naming the file and the damaged grid
bool verifyVdb(const std::filesystem::path& path);

/// Write grids and file metadata atomically, blosc-compressed; `creator` and `checksum` are added. Equal content gives
/// equal files.
/// @throws OutputError naming the file and the reason; a full disk is one
void writeVdb(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids, openvdb::MetaMap metadata);

/// A number stored as any of the numeric metadata types, or nothing.
[[nodiscard]] std::optional<double> numericMetadata(const openvdb::MetaMap& metadata, const std::string& name);

} // namespace vdblic
