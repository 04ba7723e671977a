#include "vdblic/render/annotation_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cstddef>

namespace vdblic {

AnnotationParams parseAnnotations(std::string_view text)
{
    constexpr std::string_view kTitle = "title=";
    AnnotationParams params;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::string_view rest = text.substr(begin);
        const std::string_view part = rest.substr(0, rest.find(','));
        begin += part.size() + 1;
        if (rest.starts_with(kTitle)) {
            params.title = rest.substr(kTitle.size());
            if (params.title.empty()) throw ParameterError("annotation 'title=' has no text");
            break;
        }
        if (part == "box") {
            params.box = true;
        } else if (part == "axes") {
            params.axes = true;
        } else if (part == "colorbar") {
            params.colorBar = true;
        } else if (part == "time") {
            params.time = true;
        } else if (part == "scalebar") {
            params.scaleBar = true;
        } else if (part == "triad") {
            params.triad = true;
        } else {
            throw ParameterError(
                fmt::format("'{:.60}' is no annotation; known are box, axes, colorbar, time, scalebar, "
                            "triad and title=TEXT",
                            part));
        }
    }
    return params;
}

std::string annotationText(const AnnotationParams& params)
{
    std::string text;
    const auto add = [&](bool wanted, const std::string& name) {
        if (wanted) text += (text.empty() ? "" : ",") + name;
    };
    add(params.box, "box");
    add(params.axes, "axes");
    add(params.colorBar, "colorbar");
    add(params.time, "time");
    add(params.scaleBar, "scalebar");
    add(params.triad, "triad");
    add(!params.title.empty(), "title=" + params.title);
    return text;
}

} // namespace vdblic
