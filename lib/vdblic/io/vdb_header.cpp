#include "vdblic/io/vdb_header.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/hazard.h"
#include "vdblic/io/input_file.h"
#include "vdblic/io/vdb_archive.h"
#include "vdblic/io/vdb_layout.h"

#include <fmt/format.h>

#include <cstdint>
#include <exception>
#include <fstream>
#include <string>
#include <utility>

namespace vdblic {
namespace {

/// Reads a file up to its voxels. OpenVDB's own way to do so keeps the file open.
class HeaderArchive : public VdbArchive {
  public:
    VdbHeader read(std::istream& stream)
    {
        VdbHeader header;
        readAnyHeader(stream);
        setFormatVersion(stream);
        setLibraryVersion(stream);
        setDataCompression(stream);
        header.metadata.readMeta(stream);
        if (!inputHasGridOffsets() || fileVersion() < openvdb::OPENVDB_FILE_VERSION_GRID_INSTANCING) return header;
        for (int left = readGridCount(stream); left > 0; --left) {
            openvdb::io::GridDescriptor descriptor;
            const openvdb::GridBase::Ptr grid = readDescriptor(descriptor, stream);
            descriptor.seekToGrid(stream);
            readGridCompression(stream);
            grid->readMeta(stream);
            grid->readTransform(stream);
            grid->setName(openvdb::Name(descriptor.gridName()));
            header.grids.push_back(grid);
            descriptor.seekToEnd(stream);
        }
        return header;
    }
};

} // namespace

void removeForeignMetadata(const openvdb::GridPtrVec& grids)
{
    using openvdb::GridBase;
    const auto check = [](GridBase& grid, const char* key, const std::string& type) {
        const openvdb::Metadata::ConstPtr value = std::as_const(grid)[key];
        if (value && value->typeName() != type) grid.removeMeta(key);
    };
    for (const GridBase::Ptr& grid : grids) {
        for (const char* key : {GridBase::META_GRID_CLASS, GridBase::META_GRID_CREATOR, GridBase::META_VECTOR_TYPE,
                                GridBase::META_FILE_COMPRESSION})
            check(*grid, key, openvdb::StringMetadata::staticTypeName());
        for (const char* key : {GridBase::META_IS_LOCAL_SPACE, GridBase::META_SAVE_HALF_FLOAT})
            check(*grid, key, openvdb::BoolMetadata::staticTypeName());
        for (const char* key : {GridBase::META_FILE_BBOX_MIN, GridBase::META_FILE_BBOX_MAX})
            check(*grid, key, openvdb::Vec3IMetadata::staticTypeName());
        for (const char* key : {GridBase::META_FILE_MEM_BYTES, GridBase::META_FILE_VOXEL_COUNT})
            check(*grid, key, openvdb::Int64Metadata::staticTypeName());
    }
}

VdbHeader readVdbHeader(const std::filesystem::path& path)
{
    openvdb::initialize();
    checkRegular(path);
    try {
        std::ifstream stream(path, std::ios::binary);
        const std::uintmax_t size = std::filesystem::file_size(path);
        (void)readLayout(stream, size);
        stream.clear();
        stream.seekg(0);
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        const Hazard parsing(path.string(), size);
        VdbHeader header = HeaderArchive().read(stream);
        removeForeignMetadata(header.grids);
        return header;
    } catch (const InputError& reason) {
        throw InputError(fmt::format("{}: cannot be read as a .vdb file: {}", path.string(), reason.what()));
    } catch (const std::exception&) {
        throw InputError(fmt::format("{}: its header cannot be read as that of a .vdb file", path.string()));
    }
}

std::optional<openvdb::CoordBBox> storedBox(const openvdb::GridBase& grid)
{
    const auto low = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
    const auto high = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
    if (!low || !high) return std::nullopt;
    return openvdb::CoordBBox(openvdb::Coord(low->value()), openvdb::Coord(high->value()));
}

std::optional<GridHeader> gridHeader(const VdbHeader& file, const std::string& name)
{
    for (const openvdb::GridBase::Ptr& grid : file.grids) {
        if (grid->getName() != name) continue;
        const std::optional<openvdb::CoordBBox> box = storedBox(*grid);
        return box ? std::optional(GridHeader{grid->transformPtr(), *box}) : std::nullopt;
    }
    return std::nullopt;
}

} // namespace vdblic
