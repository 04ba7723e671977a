#pragma once

#include "vdblic/core/parameters.h"

#include <glm/vec3.hpp>

#include <string>

namespace vdblic {

/// An opaque body in the picture.
struct SolidParams {
    /// Empty: none. `domain`: the inactive voxels in the box around the texture's. Else FILE or FILE:GRID, one
    /// file or a sequence with the input's frame numbers: a closed mesh (.obj, .stl, .ply), or the level set, fog
    /// volume or mask of a .vdb.
    std::string source;
    glm::dvec3 color{0.7, 0.72, 0.75}; ///< display (sRGB) values

    /// Whether each frame has a solid of its own.
    [[nodiscard]] bool changes() const;
    /// @throws ParameterError
    void validate() const;
};

[[nodiscard]] Parameters parametersOf(SolidParams& params);

} // namespace vdblic
