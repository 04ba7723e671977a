#pragma once

#include "vdblic/core/parameters.h"

#include <fmt/format.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <string>

namespace vdblic {

/// A vector as command lines have it: three numbers separated by spaces.
inline std::string vectorText(const glm::dvec3& v)
{
    return fmt::format("{} {} {}", v.x, v.y, v.z);
}

template<glm::length_t kCount, typename T>
struct WordsOf<glm::vec<kCount, T>> {
    using Scalar = T;
    static constexpr std::size_t kLeast = kCount, kMost = kCount;
    static glm::vec<kCount, T> read(const Words& words)
    {
        glm::vec<kCount, T> value;
        for (glm::length_t i = 0; i < kCount; ++i)
            value[i] = detail::scalarIn<T>(words[std::size_t(i)]);
        return value;
    }
    static Words write(const glm::vec<kCount, T>& value)
    {
        Words words;
        for (glm::length_t i = 0; i < kCount; ++i)
            words.push_back(detail::wordOf(value[i]));
        return words;
    }
};

} // namespace vdblic
