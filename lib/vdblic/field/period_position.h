#pragma once

#include "vdblic/field/period.h"
#include "vdblic/field/vector.h"

#include <cmath>

namespace vdblic {

/// The position in a periodic box that an image shows; positions in the box stay. One too far away for its precision
/// goes to the box's first voxel.
[[nodiscard]] inline Float4 wrapped(const Period& period, Float4 position)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (period.size[axis] == 0) continue;
        const auto begin = float(period.first[axis]) - 0.5f, length = float(period.size[axis]), end = begin + length;
        float at = position[axis];
        if (at >= begin && at < end) continue;
        at -= std::floor((at - begin) / length) * length;
        at += at < begin ? length : 0; // by rounding
        at -= at >= end ? length : 0;
        position[axis] = at >= begin && at < end ? at : float(period.first[axis]);
    }
    return position;
}

} // namespace vdblic
