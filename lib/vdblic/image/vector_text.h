#pragma once

#include <fmt/format.h>
#include <glm/vec3.hpp>

#include <string>

namespace vdblic {

/// A vector as the command line takes it: three numbers apart by spaces.
inline std::string vectorText(const glm::dvec3& v)
{
    return fmt::format("{} {} {}", v.x, v.y, v.z);
}

} // namespace vdblic
