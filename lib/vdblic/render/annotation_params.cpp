#include "vdblic/render/annotation_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <sstream>

namespace vdblic {
namespace {

constexpr std::string_view kPlace = "place=";

/// @param text LONGITUDE LATITUDE NAME
NamedPlace parsePlace(const std::string& text)
{
    NamedPlace place{};
    std::istringstream words(text);
    words >> place.longitude >> place.latitude >> std::ws;
    std::getline(words, place.name);
    if (place.name.empty() || !(std::abs(place.longitude) <= 360) || !(std::abs(place.latitude) <= 90)) {
        throw ParameterError(
            fmt::format("annotation 'place={:.60}' must be longitude and latitude in degrees, and a name, "
                        "such as 'place=13.4 52.5 Berlin'",
                        text));
    }
    return place;
}

} // namespace

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
        } else if (part.starts_with(kPlace)) {
            params.places.push_back(parsePlace(std::string(part.substr(kPlace.size()))));
        } else {
            throw ParameterError(
                fmt::format("'{:.60}' is no annotation; known are box, axes, colorbar, time, scalebar, "
                            "triad, place=LONGITUDE LATITUDE NAME and title=TEXT",
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
    for (const NamedPlace& place : params.places)
        add(true, fmt::format("{}{} {} {}", kPlace, place.longitude, place.latitude, place.name));
    add(!params.title.empty(), "title=" + params.title);
    return text;
}

} // namespace vdblic
