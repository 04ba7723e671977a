#include "vdblic/io/vdb_header.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>

#include <exception>
#include <fstream>

namespace vdblic {
namespace {

/// Reads a grid up to its voxels. OpenVDB's own way to do so keeps the file open.
class HeaderArchive : public openvdb::io::Archive {
  public:
    openvdb::GridBase::Ptr read(std::istream& stream, const std::string& name)
    {
        readHeader(stream);
        setFormatVersion(stream);
        setLibraryVersion(stream);
        setDataCompression(stream);
        if (!inputHasGridOffsets() || fileVersion() < openvdb::OPENVDB_FILE_VERSION_GRID_INSTANCING) return nullptr;
        openvdb::MetaMap().readMeta(stream);
        for (int left = readGridCount(stream); left > 0; --left) {
            openvdb::io::GridDescriptor descriptor;
            openvdb::GridBase::Ptr grid = descriptor.read(stream);
            if (descriptor.gridName() == name) {
                descriptor.seekToGrid(stream);
                readGridCompression(stream);
                grid->readMeta(stream);
                grid->readTransform(stream);
                return grid;
            }
            descriptor.seekToEnd(stream);
        }
        return nullptr;
    }
};

} // namespace

std::optional<GridHeader> readGridHeader(const std::filesystem::path& path, const std::string& name)
{
    openvdb::initialize();
    try {
        std::ifstream stream;
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        stream.open(path, std::ios::binary);
        const openvdb::GridBase::Ptr grid = HeaderArchive().read(stream, name);
        if (!grid) return std::nullopt;
        const auto low = grid->getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
        const auto high = grid->getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
        if (!low || !high) return std::nullopt;
        return GridHeader{grid->transformPtr(), {openvdb::Coord(low->value()), openvdb::Coord(high->value())}};
    } catch (const std::exception&) {
        throw InputError(fmt::format("{}: its header cannot be read as that of a .vdb file", path.string()));
    }
}

} // namespace vdblic
