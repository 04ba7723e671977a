#pragma once

#include "vdblic/render/shading.h"
#include "vdblic/render/texture_volume.h"
#include "vdblic/render/transfer_function.h"

namespace vdblic {

/// How the texture shows in colour and opacity.
struct TextureModulation {
    float low = 0, high = 1; ///< textures that are stretched to 0 and 1; low < high
    float strength = 1;      ///< in opacity; 0: it does not show; 1: dark texture is transparent, bright texture full
    float limbDarkening = 1; ///< in colour; 0: it does not show; 1: the dark rims of streaks are darkest
    float foot = 0.42f;      ///< stretched textures below this are the space between streaks
    float perTexture = 1 / (high - low), perRise = 1 / (1 - foot); ///< known, so that no sample has to divide

    [[nodiscard]] VDBLIC_INLINE Float8 stretched(Float8 texture) const
    {
        const Float8 t = (texture - low) * perTexture;
        const Float8 most = t < 1 ? t : broadcast8(1);
        return most > 0 ? most : Float8{};
    }
    /// The share of the extinction that is left: none below the foot, then rising smoothly to all of it.
    [[nodiscard]] VDBLIC_INLINE Float8 density(Float8 stretched) const
    {
        const Float8 rise = (stretched - foot) * perRise;
        const Float8 t = rise > 0 ? rise : Float8{};
        return 1 + (t * t * (3 - 2 * t) - 1) * strength;
    }
    /// The share of the colour that is left.
    [[nodiscard]] VDBLIC_INLINE Float8 brightness(Float8 stretched) const
    {
        constexpr float kDarkest = 0.3f;
        return 1 + (stretched - 1) * ((1 - kDarkest) * limbDarkening);
    }
};

/// Visibility-impeding halos (Interrante & Grosch 1998): the flanks of a streak hide what is behind them, so that a
/// streak in front stands apart. Only flanks turned aside count (Ebert & Rheingans 2000), so that no streak hides
/// itself.
struct Halo {
    float strength = 0; ///< extinction of a flank over that of its streak; 0: none

    /// The share of the extinction, between nothing halfway to the foot and the streak itself.
    [[nodiscard]] VDBLIC_INLINE Float8 density(const TextureModulation& texture, Float8 stretched) const
    {
        const Float8 rise = stretched * (2 / texture.foot) - 1;
        const Float8 below = rise < 1 ? rise : broadcast8(1);
        const Float8 t = below > 0 ? below : Float8{};
        return strength * t * t * (3 - 2 * t) * (1 - texture.density(stretched));
    }
};

/// What a look is made from; what is left open is chosen for a volume.
struct LookParams {
    TransferParams transfer;
    double textureStrength = 1; ///< of the modulation of opacity by texture, 0 to 1
    double limbDarkening = 1;   ///< of the modulation of colour by texture, 0 to 1
    Shading shading;
    double opticalDepth = 3; ///< of a way through the volume, where opacity is chosen automatically
    double halo = 0;         ///< strength of halos, not below 0
    double depthCue = 0;     ///< how much of the background's colour the farthest sample takes on, 0 to 1

    /// @throws ParameterError
    void validate() const;
};

/// All that makes a sample's colour and opacity.
struct Look {
    TransferFunction transfer;
    TextureModulation texture;
    Shading shading;
    Halo halo;
    float depthCue = 0;
    glm::vec3 background{0}; ///< linear light; what halos and distance fade to

    /// Whether any sample of a leaf can have an opacity.
    [[nodiscard]] bool contributes(const LeafRange& range) const;
};

/// Choose what was left open from a volume, so that an unknown one can be read.
///
/// Magnitudes range from the 2nd to the 99th percentile; textures are stretched from the 10th to the 98th. Opacity
/// rises with magnitude, scaled so that a way through the volume as long as the cube root of its number of voxels
/// has the mean optical depth asked for: one sees the front and into it, whatever the size.
/// @param samples   of one frame or of several
/// @param thickness in voxels
/// @throws InputError if there is no sample
[[nodiscard]] Look chooseLook(const LookParams& params, const TextureVolume::Samples& samples, double thickness);
/// The same for a single volume, not empty.
[[nodiscard]] Look chooseLook(const LookParams& params, const TextureVolume& volume);

} // namespace vdblic
