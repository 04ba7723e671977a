#include "vdblic/io/checkpoint_mark.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/vdb_header.h"

#include <system_error>

namespace vdblic {

bool isCheckpoint(const std::filesystem::path& path)
{
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return false;
    try {
        const openvdb::MetaMap metadata = readVdbHeader(path).metadata;
        using Keys = CheckpointKeys;
        const auto creator = metadata.getMetadata<openvdb::StringMetadata>("creator");
        return creator && creator->value().starts_with("VDBLIC ") &&
               metadata.getMetadata<openvdb::Int64Metadata>(Keys::kSteps) &&
               metadata.getMetadata<openvdb::DoubleMetadata>(Keys::kInterval) &&
               metadata.getMetadata<openvdb::DoubleMetadata>(Keys::kTime) &&
               metadata.getMetadata<openvdb::Int64Metadata>(Keys::kSpacing) &&
               metadata.getMetadata<openvdb::DoubleMetadata>(Keys::kMotion);
    } catch (const InputError&) {
        return false;
    }
}

void checkCheckpoint(const std::filesystem::path& path)
{
    const AtomicFile writable(path);
}

} // namespace vdblic
