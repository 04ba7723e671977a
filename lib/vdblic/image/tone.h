#pragma once

#include "vdblic/image/image.h"

#include <glm/vec3.hpp>

namespace vdblic {

/// A picture taken with another exposure: its light times 2^stops.
[[nodiscard]] Image exposed(Image image, double stops);

/// Light that a screen can show, 0 to 1 in each channel, of light that may be brighter: a film's shoulder. Channels of
/// at most `knee` stay as they are. The largest channel of brighter light approaches 1, and its others follow in
/// proportion, so that hues stay; very bright light also fades to white.
///
/// The curve above its toe of the Khronos PBR Neutral Tone Mapper (Khronos Group 2024).
/// @param knee at least kToneKnee; 1: brighter light has a largest channel of 1
[[nodiscard]] glm::vec3 toneMapped(const glm::vec3& light, float knee);
inline constexpr float kToneKnee = 0.8f;

} // namespace vdblic
