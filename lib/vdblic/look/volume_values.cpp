#include "vdblic/look/volume_values.h"

namespace vdblic {

void VolumeSamples::append(const VolumeSamples& more)
{
    texture.insert(texture.end(), more.texture.begin(), more.texture.end());
    driver.insert(driver.end(), more.driver.begin(), more.driver.end());
    color.insert(color.end(), more.color.begin(), more.color.end());
}

} // namespace vdblic
