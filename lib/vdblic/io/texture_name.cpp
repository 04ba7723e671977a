#include "vdblic/io/texture_name.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/sequence.h"
#include "vdblic/io/vdb_header.h"

namespace vdblic {

bool isSparse(const openvdb::MetaMap& fileMetadata)
{
    const auto stored = fileMetadata.getMetadata<openvdb::StringMetadata>(kInactiveKey);
    return stored && stored->value() == kEmpty;
}

bool isSparse(const SequenceParams& sequence)
{
    if (sequence.pattern == "-") return false;
    try {
        return isSparse(readVdbHeader(selectFrames(sequence).front().path).metadata);
    } catch (const Error&) { // is reported when the file is read
        return false;
    }
}

std::vector<std::string> sourceNames(const openvdb::MetaMap& fileMetadata)
{
    std::vector<std::string> names;
    const auto next = [&] {
        return fileMetadata.getMetadata<openvdb::StringMetadata>(kSourceKey + std::to_string(names.size() + 1));
    };
    for (auto name = next(); name; name = next())
        names.push_back(name->value());
    return names;
}

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
