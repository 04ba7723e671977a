#pragma once

#include "vdblic/render/texture_volume.h"
#include "vdblic/render/transfer_function.h"

namespace vdblic {

/// How the texture shows in colour and opacity.
struct TextureModulation {
    float low = 0, high = 1; ///< textures that are stretched to 0 and 1; low < high
    float strength = 1;      ///< 0: it does not show; 1: dark texture is transparent, bright texture fully opaque

    [[nodiscard]] VDBLIC_INLINE Float8 stretched(Float8 texture) const
    {
        const Float8 t = (texture - low) * (1 / (high - low));
        const Float8 most = t < 1 ? t : broadcast8(1);
        return most > 0 ? most : Float8{};
    }
    /// The share of the extinction that is left: none below the foot, then rising smoothly to all of it.
    [[nodiscard]] VDBLIC_INLINE Float8 density(Float8 stretched) const
    {
        constexpr float kFoot = 0.42f;
        const Float8 rise = (stretched - kFoot) * (1 / (1 - kFoot));
        const Float8 t = rise > 0 ? rise : Float8{};
        return 1 + (t * t * (3 - 2 * t) - 1) * strength;
    }
    /// The share of the colour that is left.
    [[nodiscard]] VDBLIC_INLINE Float8 brightness(Float8 stretched) const
    {
        constexpr float kDarkest = 0.3f;
        return 1 + (stretched - 1) * ((1 - kDarkest) * strength);
    }
};

/// A head light with Phong's reflection, two-sided, the texture's gradient as the normal. The highlight's power is
/// Schlick's rational form of it (Graphics Gems IV, 1994).
struct Shading {
    float ambient = 0.45f;
    float diffuse = 0.9f;
    float specular = 0.2f;
    float shininess = 24;
    /// Gradients of the stretched texture [1/voxel] much below this are no surface and are not lit.
    float leastGradient = 0.08f;

    /// @throws ParameterError
    void validate() const;
};

/// What a look is made from; what is left open is chosen for a volume.
struct LookParams {
    TransferParams transfer;
    double textureStrength = 1; ///< of the modulation by texture, 0 to 1
    Shading shading;

    /// @throws ParameterError
    void validate() const;
};

/// All that makes a sample's colour and opacity.
struct Look {
    TransferFunction transfer;
    TextureModulation texture;
    Shading shading;

    /// Whether any sample of a leaf can have an opacity.
    [[nodiscard]] bool contributes(const LeafRange& range) const;
};

/// Choose what was left open from a volume, so that an unknown one can be read.
///
/// Magnitudes range from the 2nd to the 99th percentile; textures are stretched from the 10th to the 98th. Opacity
/// rises with magnitude, scaled so that a way through the volume as long as the cube root of its number of voxels
/// has a mean optical depth of 3: one sees the front and into it, whatever the size.
/// @param volume not empty
[[nodiscard]] Look chooseLook(const LookParams& params, const TextureVolume& volume);

} // namespace vdblic
