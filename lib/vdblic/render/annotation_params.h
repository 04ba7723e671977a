#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// A place on a globe (field/globe.h).
struct NamedPlace {
    double longitude, latitude; ///< [degrees]
    std::string name;
};

/// Explanations drawn over a picture.
struct AnnotationParams {
    bool box = false;      ///< outline of the domain, its far edges behind the volume
    bool axes = false;     ///< ticks in world units along three edges of the domain
    bool colorBar = false; ///< scales of the scalars for colour and opacity
    bool time = false;     ///< frame and time
    bool scaleBar = false; ///< a bar of round length
    bool triad = false;    ///< directions of the axes
    std::vector<NamedPlace> places{};
    std::string title{};

    [[nodiscard]] bool any() const
    {
        return box || axes || colorBar || time || scaleBar || triad || !places.empty() || !title.empty();
    }
};

/// Parse `box,axes,colorbar,time,scalebar,triad,place=LONGITUDE LATITUDE NAME,title=TEXT`; the title is the rest of the
/// text. @throws ParameterError
[[nodiscard]] AnnotationParams parseAnnotations(std::string_view text);
/// The text that parseAnnotations() reads back.
[[nodiscard]] std::string annotationText(const AnnotationParams& params);

} // namespace vdblic
