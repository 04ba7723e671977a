#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/film/film_params.h"

namespace vdblic {

/// Make a film or a still from a velocity sequence: plan, compute the textures, render them.
///
/// Textures wait in the folder OUTPUT.textures until the output is complete; then the folder is removed. After an
/// interruption the same call goes on with those that are finished, and writes the same output. Textures of other
/// parameters or of inputs that have changed since are replaced. One process at a time makes an output (OutputLock).
///
/// @throws ParameterError, InputError, OutputError, Stopped
void makeFilm(const FilmParams& params, Reporter& reporter);

} // namespace vdblic
