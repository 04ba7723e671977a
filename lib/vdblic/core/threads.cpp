#include "vdblic/core/threads.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace vdblic {

std::size_t threadCount()
{
    return std::min(std::size_t(tbb::this_task_arena::max_concurrency()),
                    tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

} // namespace vdblic
