#pragma once

#include <string>

namespace vdblic {

/// The font family for a text: DejaVu Sans, or another installed one if that lacks a character.
struct AnnotationFont {
    std::string family;
    std::string missing; ///< characters that the font lacks, and every other one too
};
[[nodiscard]] AnnotationFont annotationFont(const std::string& text);

} // namespace vdblic
