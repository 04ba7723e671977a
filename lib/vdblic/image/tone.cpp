#include "vdblic/image/tone.h"

#include <glm/common.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>

namespace vdblic {

Image exposed(Image image, double stops)
{
    if (stops == 0) return image;
    const auto gain = float(std::exp2(stops));
    for (glm::vec4& pixel : image.pixels)
        pixel = glm::vec4(glm::vec3(pixel) * gain, pixel.a);
    return image;
}

glm::vec3 toneMapped(const glm::vec3& light, float knee)
{
    constexpr float kFading = 0.15f;
    const float most = std::max({light.r, light.g, light.b});
    if (!(most > knee)) return light;
    const float room = 1 - knee;
    const float shown = 1 - room * room / (most - knee + room);
    const float white = 1 - 1 / (kFading * (most - shown) + 1);
    return glm::mix(light * (shown / most), glm::vec3(shown), white);
}

} // namespace vdblic
