#pragma once

#include "vdblic/core/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace vdblic {

/// The names of an enumeration's values, in order. Specialised for each enumeration of a parameter.
template<typename Enum>
inline constexpr auto kNames = std::array<std::string_view, 0>{};

template<typename Enum>
[[nodiscard]] constexpr std::string_view nameOf(Enum value)
{
    return kNames<Enum>[std::size_t(value)];
}

/// The value of a name. @throws ParameterError that lists all names
template<typename Enum>
[[nodiscard]] Enum valueOf(std::string_view name)
{
    const auto& names = kNames<Enum>;
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) throw ParameterError(fmt::format("'{}' is none of {}", name, fmt::join(names, ", ")));
    return Enum(found - names.begin());
}

} // namespace vdblic
