#pragma once

#include <cstddef>

namespace vdblic {

class Exchange;
struct FrameFile;
struct PicturePlan;
struct RenderPlan;

/// Estimated memory of a frame by the number of its voxels [bytes]; 0 if the file does not have that number.
[[nodiscard]] double frameBytes(const PicturePlan& plan, const FrameFile& file);

/// Bytes that this process may allocate without making the system swap.
[[nodiscard]] double availableMemory();

/// Number of frames to render at a time: one for each thread, but no more than half of the free memory holds; at least
/// one. With fewer frames than threads, the threads share the tiles of each frame.
/// @param frameBytes memory of one frame
[[nodiscard]] std::size_t framesInFlight(double frameBytes);
/// The same for a given number of threads and of free bytes.
[[nodiscard]] std::size_t framesInFlight(double frameBytes, std::size_t threads, double freeBytes);

/// Whether ranks are to share each picture: if there are fewer pictures than ranks, or if a frame needs more than
/// half of a rank's memory. Else each rank makes pictures of its own. Collective. @throws as momentsOf()
[[nodiscard]] bool ranksShareFrames(const RenderPlan& plan, Exchange& exchange);

} // namespace vdblic
