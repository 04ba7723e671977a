#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/look/look_params.h"
#include "vdblic/look/shading.h"
#include "vdblic/look/transfer_function.h"
#include "vdblic/look/volume_values.h"

#include <glm/vec3.hpp>

namespace vdblic {

/// How the texture shows in colour and opacity.
struct TextureModulation {
    float low = 0, high = 1; ///< textures that are stretched to 0 and 1; low < high
    float strength = 1;      ///< of the effect on opacity; 0: none; 1: dark texture is transparent
    float limbDarkening = 1; ///< of the effect on colour; 0: none; 1: the dark rims of streaks are darkest
    float foot = 0.42f;      ///< stretched textures below this are the space between streaks
    float perTexture = 1 / (high - low), perRise = 1 / (1 - foot); ///< precomputed: samples need no division

    [[nodiscard]] VDBLIC_INLINE Float8 stretched(Float8 texture) const
    {
        const Float8 t = (texture - low) * perTexture;
        const Float8 most = t < 1 ? t : broadcast8(1);
        return most > 0 ? most : Float8{};
    }
    /// Factor on the extinction: 0 below the foot, then a smooth rise to 1.
    [[nodiscard]] VDBLIC_INLINE Float8 density(Float8 stretched) const
    {
        const Float8 rise = (stretched - foot) * perRise;
        const Float8 t = rise > 0 ? rise : Float8{};
        return 1 + (t * t * (3 - 2 * t) - 1) * strength;
    }
    /// Factor on the colour.
    [[nodiscard]] VDBLIC_INLINE Float8 brightness(Float8 stretched) const
    {
        constexpr float kDarkest = 0.3f;
        return 1 + (stretched - 1) * ((1 - kDarkest) * limbDarkening);
    }
};

/// Visibility-impeding halos (Interrante & Grosch 1998): the flanks of a streak hide what is behind them, so that a
/// streak in front stands apart. Only flanks seen edge-on count (Ebert & Rheingans 2000): no streak hides itself.
struct Halo {
    float strength = 0; ///< extinction of a flank over that of its streak; 0: none

    /// Factor on the extinction, above 0 only between half the foot and the streak itself.
    [[nodiscard]] VDBLIC_INLINE Float8 density(const TextureModulation& texture, Float8 stretched) const
    {
        const Float8 rise = stretched * (2 / texture.foot) - 1;
        const Float8 below = rise < 1 ? rise : broadcast8(1);
        const Float8 t = below > 0 ? below : Float8{};
        return strength * t * t * (3 - 2 * t) * (1 - texture.density(stretched));
    }
};

/// All that determines a sample's colour and opacity.
struct Look {
    TransferFunction transfer;
    TextureModulation texture;
    Shading shading;
    Halo halo;
    float depthCue = 0;
    float shadows = 0;       ///< see LightGrid
    glm::vec3 background{0}; ///< linear light; what halos and distance fade to

    /// Whether any sample of a leaf can have an opacity above 0.
    [[nodiscard]] bool contributes(const LeafRange& range) const;
};

/// Choose what the parameters leave open, so that an unknown volume can be read.
///
/// A scalar's range is its 2nd to 99th percentile; that of one that only opacity follows begins at 0 if it has both
/// signs. Textures are stretched from the 10th to the 98th percentile. Opacity rises with its scalar. It is scaled so
/// that a path as long as `thickness` has the mean optical depth asked for: the front is seen, and some of what lies
/// behind, whatever the volume's size.
/// @param samples   of one frame or of several
/// @param thickness [voxels]
/// @throws ParameterError; InputError if there is no sample
[[nodiscard]] Look chooseLook(const LookParams& params, const VolumeSamples& samples, double thickness);

} // namespace vdblic
