#include "vdblic/io/texture_name.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_header.h"

namespace vdblic {

std::string textureName(const openvdb::MetaMap& fileMetadata, const std::string& given)
{
    if (!given.empty()) return given;
    const auto stored = fileMetadata.getMetadata<openvdb::StringMetadata>(kTextureKey);
    return stored ? stored->value() : "density";
}

std::string textureName(const std::filesystem::path& path, const std::string& given)
{
    if (!given.empty()) return given;
    try {
        return textureName(readVdbHeader(path).metadata, given);
    } catch (const InputError&) {
        return {};
    }
}

} // namespace vdblic
