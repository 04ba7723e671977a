#pragma once

#include <string>
#include <string_view>

namespace vdblic {

/// Explanations drawn over a picture.
struct AnnotationParams {
    bool box = false;      ///< outline of the domain, its far edges behind the volume
    bool axes = false;     ///< ticks in world units along three edges of the domain
    bool colorBar = false; ///< scales of the scalars for colour and opacity
    bool time = false;     ///< frame and time
    bool scaleBar = false; ///< a bar of round length
    bool triad = false;    ///< directions of the axes
    std::string title{};

    [[nodiscard]] bool any() const { return box || axes || colorBar || time || scaleBar || triad || !title.empty(); }
};

/// Parse `box,axes,colorbar,time,scalebar,triad,title=TEXT`; the title is the rest of the text. @throws ParameterError
[[nodiscard]] AnnotationParams parseAnnotations(std::string_view text);
/// The text that parseAnnotations() reads back.
[[nodiscard]] std::string annotationText(const AnnotationParams& params);

} // namespace vdblic
