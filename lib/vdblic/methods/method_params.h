#pragma once

#include "vdblic/methods/backward/backward_params.h"
#include "vdblic/methods/streaks/streak_params.h"
#include "vdblic/methods/texture_params.h"

#include <openvdb/openvdb.h>

namespace vdblic {

/// The parameters of all methods; TextureParams::method chooses one.
struct MethodParams {
    TextureParams texture{};
    StreakParams streaks{};    ///< of the method streaks
    BackwardParams backward{}; ///< of the methods that look back
};

// Parts of the description of several methods.

[[nodiscard]] int lifeSpanOf(const MethodParams& params);
[[nodiscard]] int twoLifeSpansOf(const MethodParams& params);
void describeLifeSpan(const MethodParams& params, openvdb::MetaMap& metadata);

} // namespace vdblic
