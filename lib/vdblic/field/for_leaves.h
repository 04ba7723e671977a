#pragma once

#include "vdblic/core/paging.h"
#include "vdblic/field/domain.h"

#include <tbb/parallel_for.h>

#include <cstddef>

namespace vdblic {

/// Call work(leaf) for each given leaf, in parallel. Throttled by paging::breathe().
template<typename Work>
void forLeaves(Domain::Leaves leaves, const Work& work)
{
    tbb::parallel_for(std::size_t(0), leaves.size(), [&](std::size_t i) {
        paging::breathe(paging::kLeafBytes);
        work(std::size_t(leaves[i]));
    });
}

} // namespace vdblic
