#include "vdblic/io/whole_vdb.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>

namespace vdblic {

bool isWholeVdb(const std::filesystem::path& output, Reporter& reporter)
{
    if (!isFinished(output)) return false;
    try {
        (void)verifyVdb(output);
        return true;
    } catch (const InputError& error) {
        reporter.warn(fmt::format("{}; it is made again", error.what()));
        return false;
    }
}

} // namespace vdblic
