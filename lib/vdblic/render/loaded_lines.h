#pragma once

#include "vdblic/render/loaded_texture.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace vdblic {

struct Moment;

/// Whether a file is shown by its lines: by its header. @param name of its texture; empty: by its metadata
/// @throws InputError naming the file
[[nodiscard]] bool hasLines(const std::filesystem::path& path, const std::string& name);

/// The lines of a file, if it has any.
/// @param chosenOpacity scalar that opacity follows in all frames; empty: not chosen yet
/// @throws InputError naming the file: also if it has lines, and the plan has others to draw in voxels
[[nodiscard]] std::optional<LoadedTexture> linesIn(const PicturePlan& plan, const VdbFile& file, const FrameFile& frame,
                                                   const std::string& chosenOpacity);

/// The lines that are drawn in a frame's voxels. @throws InputError naming their file
[[nodiscard]] std::shared_ptr<const LoadedTexture> linesBeside(const PicturePlan& plan, const FrameFile& frame,
                                                               const View* view);

/// The lines at a moment between two frames. Thread-safe.
/// @throws InputError naming the file: if one of the frames has no lines or no time, if one is turned against the
/// other,
///         or if tails are too short to join
[[nodiscard]] LoadedTexture linesAt(const PicturePlan& plan, const Moment& moment, const View* view);

} // namespace vdblic
