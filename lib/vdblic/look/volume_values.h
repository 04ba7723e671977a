#pragma once

#include <vector>

namespace vdblic {

/// Bounds of all samples in a leaf.
struct LeafRange {
    float lowDriver, highDriver, highTexture;
};

/// Values of some of a volume's shown voxels.
struct VolumeSamples {
    std::vector<float> texture, driver, color; ///< color is empty if the driver colours

    void append(const VolumeSamples& more);
};

} // namespace vdblic
