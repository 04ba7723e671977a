#pragma once

#include "vdblic/film/film.h"
#include "vdblic/run/sequence_info.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace vdblic {

/// How a film is made: what vdblic_advect and vdblic_render are given, by the keys of their parameters.
struct FilmPlan {
    std::map<std::string, Words> advect, render; ///< without the textures' pattern
    std::size_t textures = 1, pictures = 1;      ///< a film may leave out textures of its last interval
    double textureVoxels = 0, textureBytes = 0;  ///< of a dense texture; estimate of the memory that making it takes
    double pictureBytes = 0, seconds = 0;        ///< estimates for streaks: memory of a picture, all processor time
    std::vector<std::string> notes;              ///< what was chosen and why, for people
};

/// Choose what suits a sequence: streaks about 24 pixels apart, textures whose voxels are two pixels (dense ones three)
/// within half of the memory, and so many substeps that the faster half of the flow moves 10 pixels a picture.
/// @param info with its values
/// @throws InputError if there is no velocity, a file is damaged, or the flow is at rest
[[nodiscard]] FilmPlan planFilm(const FilmParams& params, const SequenceInfo& info);

/// The two commands that do the same. @param textures pattern
[[nodiscard]] std::vector<std::string> commandsOf(const FilmPlan& plan, const std::string& textures);

} // namespace vdblic
