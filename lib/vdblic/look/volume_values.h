#pragma once

#include <vector>

namespace vdblic {

/// Bounds of all samples in a leaf.
struct LeafRange {
    float lowDriver, highDriver, highTexture;
};

/// Values at a sample of a volume's shown voxels.
struct VolumeSamples {
    std::vector<float> texture, driver, color; ///< color is empty if the driver colours

    void append(const VolumeSamples& more)
    {
        texture.insert(texture.end(), more.texture.begin(), more.texture.end());
        driver.insert(driver.end(), more.driver.begin(), more.driver.end());
        color.insert(color.end(), more.color.begin(), more.color.end());
    }
};

} // namespace vdblic
