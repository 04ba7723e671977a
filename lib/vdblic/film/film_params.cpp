#include "vdblic/film/film_params.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/look/look_preset.h"

#include <algorithm>
#include <filesystem>

namespace vdblic {
namespace {

constexpr int kMostSide = 32768;

} // namespace

Parameters parametersOf(FilmParams& params)
{
    Parameter input = parametersOf(params.input, "VELOCITY",
                                   "Velocity sequence: one file, or a pattern (name.%04d.vdb, also ####, @@@@, $F4, "
                                   "<F4>).")
                          .front();
    Parameter look = parameter("look", "Look of the pictures; by default streaks, of dense textures flow.", params.look,
                               {.words = "NAME"});
    look.choices = lookPresetNames();
    return {
        input,
        parameter("output", "Film, .mp4, or still of the middle frame, .png.", params.output,
                  {.option = "-o,--output", .isRequired = true, .isFile = true}),
        parameter("seconds", "Length of the film; by default what suits the flow, 2 to 10.", params.seconds,
                  {.unit = "s", .limits = {0.1, 3600}}),
        parameter("size", "Size of the pictures.", params.size,
                  {.unit = "pixels", .words = "W H", .limits = {2, kMostSide}}),
        look,
        parameter("orbit", "Turns of the camera around the flow during the film.", params.orbit,
                  {.unit = "turns", .limits = {-100, 100}}),
        parameter("preview", "Half the width and height, half the pictures, coarser textures: a first look.",
                  params.preview),
        parameter("method", "Streaks show which way the flow goes, a dense texture fills every voxel.", params.method,
                  {.words = "NAME"}),
    };
}

bool FilmParams::isStill() const
{
    return std::filesystem::path(output).extension() == ".png";
}

glm::ivec2 FilmParams::pictureSize() const
{
    const auto side = [&](int given) { return preview ? std::max(given / 2, 1) : given; };
    return {side(size[0]), side(size[1])};
}

double FilmParams::picturesPerSecond() const
{
    return preview ? 12 : 24;
}

void FilmParams::validate() const
{
    FilmParams copy = *this;
    checkLimits(parametersOf(copy));
    checkExtension(output, {".mp4", ".png"});
    if (input.pattern == "-")
        throw ParameterError("paths on standard input cannot be planned; name a file or a pattern");
    if (!look.empty()) (void)lookPreset(look);
    if (isStill() && (seconds || orbit != 0))
        throw ParameterError("`seconds` and `orbit` are of films, and a .png is a still: leave them out");
}

} // namespace vdblic
