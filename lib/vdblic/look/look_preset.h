#pragma once

#include "vdblic/look/look.h"

#include <glm/vec3.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// A look with a name, tuned to be good on unknown data.
struct LookPreset {
    std::string name;
    LookParams look;
    Background background;
    std::vector<std::string> opacityBy{}; ///< grids that opacity follows, the best one first; empty: as colour
};

/// The names lookPreset() knows.
[[nodiscard]] std::vector<std::string> lookPresetNames();

/// The default look: `flow`, or `streaks` for a sparse texture.
[[nodiscard]] std::string defaultLookName(bool isSparse);

/// `flow`: coloured streaks, lit; `vortex`: the same, opaque where the flow turns; `streaks`: lit
/// tubes, for sparse textures; `paper`: lit streaks on a bright ground; `ink`: dark strokes on paper;
/// `smoke`: soft and grey; `xray`: all depths at once.
/// @throws ParameterError on an unknown name, listing the known ones
[[nodiscard]] LookPreset lookPreset(std::string_view name);

} // namespace vdblic
