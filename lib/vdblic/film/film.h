#pragma once

#include "vdblic/camera/camera.h"
#include "vdblic/core/names.h"
#include "vdblic/core/parameters.h"
#include "vdblic/core/reporter.h"
#include "vdblic/flow/reference_frame.h"
#include "vdblic/io/sequence.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// The texture of a film: sparse streaks, a dense texture, or a dense one with streaks in it.
enum class FilmMethod { kStreaks, kDense, kBoth };
template<>
inline constexpr auto kNames<FilmMethod> = std::to_array<std::string_view>({"streaks", "dense", "both"});

/// The parameters of a film, a still or a page of a velocity sequence. planFilm() chooses all others from the data.
struct FilmParams {
    SequenceParams input;
    bool globe = false;              ///< place longitude and latitude on a globe; of inputs for vdblic_import
    std::string output;              ///< .mp4 film, .png still of the middle frame, or .html page
    std::optional<double> seconds{}; ///< length of the film; unset: 5 to 10, by the flow
    std::optional<double> fps{};     ///< pictures a second; unset: 24, in a preview 12
    std::array<int, 2> size{1280, 720};
    std::string look{}; ///< empty: the method's
    ViewSide view = ViewSide::kThreeQuarter;
    std::optional<glm::dvec2> angles{};      ///< as in CameraParams, in place of `view`
    std::string solid{};                     ///< as in PictureParams; empty: the box's inactive voxels
    glm::dvec3 solidColor{0.42, 0.44, 0.47}; ///< as displayed; darker than the flow
    bool plain = false;                      ///< without colour bar, time and scale bar
    double orbit = 0;                        ///< turns of the camera during the film
    std::vector<std::string> periodic{};     ///< DomainParams::periodic
    bool preview = false;                    ///< half the width and height, half the pictures, coarser textures
    FilmMethod method = FilmMethod::kStreaks;
    ReferenceFrameParams observer{}; ///< as of the textures

    [[nodiscard]] bool isFilm() const;
    [[nodiscard]] bool isStill() const;
    [[nodiscard]] bool isPage() const;            ///< of lines, for browsers
    [[nodiscard]] glm::ivec2 pictureSize() const; ///< of a preview half the size
    [[nodiscard]] double picturesPerSecond() const;
    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(FilmParams& params);

/// Make a film, a still or a page from a velocity sequence: plan, compute the textures, render them; vdblic_export
/// makes a page of them. An input in a format of other programs goes through vdblic_import first; its velocity waits in
/// the folder OUTPUT.velocity.
///
/// Textures wait in the folder OUTPUT.textures until the output is complete; then the folder is removed. After an
/// interruption the same call reuses the finished ones and writes the same output. Textures of other parameters, or of
/// inputs that have changed since, are replaced. One process at a time makes an output (OutputLock).
///
/// @throws ParameterError, InputError, OutputError, Stopped
void makeFilm(const FilmParams& params, Reporter& reporter);

} // namespace vdblic
