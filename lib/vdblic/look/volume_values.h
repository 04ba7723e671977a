#pragma once

#include <vector>

namespace vdblic {

/// Bounds of the active values in a padded leaf, and so of all samples in the leaf.
struct LeafRange {
    float lowDriver, highDriver, highTexture;
};

/// Values of some of a volume's shown voxels.
struct VolumeSamples {
    std::vector<float> texture, driver, color; ///< color is empty if the driver colours

    void append(const VolumeSamples& more);
};

} // namespace vdblic
