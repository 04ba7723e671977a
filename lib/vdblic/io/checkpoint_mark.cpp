#include "vdblic/io/checkpoint_mark.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/vdb_header.h"

#include <algorithm>
#include <array>
#include <system_error>

namespace vdblic {

bool isCheckpoint(const std::filesystem::path& path)
{
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return false;
    try {
        const openvdb::MetaMap metadata = readVdbHeader(path).metadata;
        using Keys = CheckpointKeys;
        constexpr std::array keys = {Keys::kSteps, Keys::kInterval, Keys::kTime, Keys::kSpacing, Keys::kMotion};
        return std::all_of(keys.begin(), keys.end(), [&](const char* key) { return bool(metadata[key]); });
    } catch (const InputError&) {
        return false;
    }
}

void checkCheckpoint(const std::filesystem::path& path)
{
    const AtomicFile writable(path);
}

} // namespace vdblic
