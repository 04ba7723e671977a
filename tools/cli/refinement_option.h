#pragma once

#include "vdblic/core/errors.h"
#include "vdblic/field/refinement.h"

#include <vector>

namespace vdblic::cli {

/// The refinement of `--refine N` or `--refine NX NY NZ`. @throws ParameterError on another count of numbers
inline Refinement refinementOf(const std::vector<int>& factors)
{
    if (factors.size() == 1) return {{factors[0], factors[0], factors[0]}};
    if (factors.size() == 3) return {{factors[0], factors[1], factors[2]}};
    throw ParameterError("--refine takes one number, or one for each of the three axes");
}

} // namespace vdblic::cli
