#pragma once

#include "vdblic/film/film.h"
#include "vdblic/render/render_params.h"
#include "vdblic/run/sequence_info.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

inline constexpr std::string_view kPageTool = "vdblic_export";

/// The parameters of vdblic_advect and vdblic_render that make a film, by key, without the patterns of texturesOf().
struct FilmPlan {
    std::vector<Given> runs; ///< of vdblic_advect: for the textures, and for lines in them, if any
    Given render;
    Words page;                             ///< of a page: words of kPageTool, without the textures' pattern
    std::size_t textures = 1, pictures = 1; ///< textures of a run; a film may leave out the end of its last interval
    double textureVoxels = 0, textureBytes = 0; ///< voxels of a dense texture, estimated memory to make textures
    double pictureBytes = 0, seconds = 0;       ///< estimates: memory of a picture, processor time of the whole
    std::vector<std::string> notes;             ///< the choices and their reasons, for people
};

/// Choose the parameters for a sequence: streaks about 24 pixels apart, textures whose voxels are two pixels (dense
/// ones three) within half of the memory, and so many substeps that the faster half of the flow moves 10 pixels a
/// picture.
/// @param info with its values
/// @throws InputError if there is no velocity, a file is damaged, or the flow is at rest
[[nodiscard]] FilmPlan planFilm(const FilmParams& params, const SequenceInfo& info);

/// The pattern of a run's textures. @param stem folder and begin of their names
[[nodiscard]] std::string texturesOf(const std::string& stem, std::size_t run);

/// The parameters of a run and of vdblic_render with the patterns of textures.
[[nodiscard]] Given advectOf(const FilmPlan& plan, const std::string& stem, std::size_t run);
[[nodiscard]] Given renderOf(const FilmPlan& plan, const std::string& stem);

/// The commands for a plan: of vdblic_advect for each run, and of vdblic_render or kPageTool. @param stem of
/// texturesOf()
[[nodiscard]] std::vector<std::string> commandsOf(const FilmPlan& plan, const std::string& stem);

} // namespace vdblic
