#pragma once

#include <glm/vec3.hpp>

#include <vector>

namespace vdblic {

class Exchange;
class TextureVolume;
struct ClipParams;
struct Look;

/// Points around what a look shows of a volume, in world space: corners of leaves, a hundred of the outermost.
/// Leaves that are almost transparent, hidden or cut away do not count.
/// @param exchange of the ranks that share the volume: collective
/// @return nothing if all of the volume is invisible
[[nodiscard]] std::vector<glm::dvec3> visibleExtent(const TextureVolume& volume, const Look& look,
                                                    const ClipParams& clip, Exchange& exchange);

} // namespace vdblic
