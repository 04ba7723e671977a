#pragma once

#include "vdblic/field/domain.h"

#include <tbb/parallel_for.h>

#include <cstddef>

namespace vdblic {

/// Call work(leaf) for each of some leaves, in parallel.
template<typename Work>
void forLeaves(Domain::Leaves leaves, const Work& work)
{
    tbb::parallel_for(std::size_t(0), leaves.size(), [&](std::size_t i) { work(std::size_t(leaves[i])); });
}

} // namespace vdblic
