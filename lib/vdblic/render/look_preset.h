#pragma once

#include "vdblic/render/look.h"

#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// A look with a name, made to be good at once on unknown data.
struct LookPreset {
    LookParams look;
    glm::dvec3 background; ///< as displayed
};

/// The names lookPreset() knows.
[[nodiscard]] std::vector<std::string> lookPresetNames();

/// `flow`: coloured streaks, lit; `ink`: dark strokes on paper; `smoke`: soft and grey; `xray`: all depths at once.
/// @throws ParameterError on an unknown name, listing the known ones
[[nodiscard]] LookPreset lookPreset(std::string_view name);

} // namespace vdblic
