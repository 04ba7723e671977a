#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/render/render_params.h"

#include <iosfwd>

namespace vdblic {

class Exchange;
struct RenderPlan;

/// Render each frame of a texture sequence, as many at a time as there are threads and memory for.
///
/// A file holds the texture and, on the same transform, the driver: the grid that drives the transfer function. Without
/// a grid of the driver's default name the texture itself drives it. Automatic choices are made once for the sequence:
/// the camera such that all frames on disk are seen, the look from a few of those frames, whichever frames are
/// selected. So machines that each render a part of the frames make one animation. Of paths on standard input, the
/// first frame with an active voxel decides. A frame without active voxels is all background.
///
/// The histograms cover all rendered frames; without an output only they are made.
/// @param lines source of paths if the input is `-`
/// @throws ParameterError, InputError naming the file, OutputError; images finished before remain
void renderSequence(const RenderParams& params, std::istream& lines, Reporter& reporter);

/// The same for resolved parameters. Several ranks share each frame: each reads and casts its part of the picture, and
/// rank 0 writes the whole. The input must be a pattern or a file, without film and histograms. Collective.
void renderSequence(const RenderPlan& plan, std::istream& lines, Reporter& reporter, Exchange& exchange);

} // namespace vdblic
