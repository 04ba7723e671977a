#include "vdblic/render/frame_metadata.h"

#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/render_params.h"

namespace vdblic {

std::string textOf(const openvdb::MetaMap& metadata, const char* key)
{
    const auto text = metadata.getMetadata<openvdb::StringMetadata>(key);
    return text ? text->value() : "";
}

FrameClock clockOf(const openvdb::MetaMap& metadata)
{
    return {numericMetadata(metadata, "time"), numericMetadata(metadata, "dt"), textOf(metadata, "start")};
}

std::string unitOf(const openvdb::FloatGrid& scalar, const std::string& lengthUnit)
{
    std::string unit = textOf(scalar, "unit");
    if (!unit.empty() || scalar.getName() != kSpeedGrid || lengthUnit.empty()) return unit;
    return lengthUnit + "/s";
}

std::vector<std::string> kindsOf(const openvdb::MetaMap& metadata)
{
    std::vector<std::string> kinds = sourceNames(metadata);
    if (!kinds.empty()) kinds.insert(kinds.begin(), "no source");
    return kinds;
}

} // namespace vdblic
