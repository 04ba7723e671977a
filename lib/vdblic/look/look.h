#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/image/image_file.h"
#include "vdblic/look/look_params.h"
#include "vdblic/look/shading.h"
#include "vdblic/look/transfer_function.h"
#include "vdblic/look/volume_values.h"

#include <glm/vec3.hpp>

#include <limits>
#include <vector>

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
    /// The mean of density() over textures that change evenly from one to another along a step: pre-integration (Engel,
    /// Kraus & Ertl 2001), in closed form.
    [[nodiscard]] VDBLIC_INLINE Float8 meanDensity(Float8 from, Float8 to) const
    {
        const Float8 change = to - from;
        const Int8 isSmall = (change < kSmall) & (change > -kSmall);
        const Float8 mean = (integral(to) - integral(from)) / (isSmall ? Float8{} + 1 : change);
        return isSmall ? density((from + to) * 0.5f) : mean;
    }
    /// Factor on the colour.
    [[nodiscard]] VDBLIC_INLINE Float8 brightness(Float8 stretched) const
    {
        constexpr float kDarkest = 0.3f;
        return 1 + (stretched - 1) * ((1 - kDarkest) * limbDarkening);
    }

  private:
    static constexpr float kSmall = 1 / 256.0f; // change below which the difference of integrals would be too coarse

    /// Of density(), up to a constant.
    [[nodiscard]] VDBLIC_INLINE Float8 integral(Float8 stretched) const
    {
        const Float8 rise = (stretched - foot) * perRise;
        const Float8 t = rise > 0 ? rise : Float8{};
        return stretched * (1 - strength) + t * t * t * (1 - 0.5f * t) * ((1 - foot) * strength);
    }
};

/// Visibility-impeding halos (Interrante & Grosch 1998): the flanks of a streak hide the volume behind them, so that a
/// streak in front stands apart. Only flanks seen edge-on count (Ebert & Rheingans 2000): no streak hides itself. A
/// tube has them in its outline.
struct Halo {
    float strength = 0; ///< ratio of a flank's extinction to its streak's; 0: none

    /// Factor on the extinction, above 0 only between half the foot and the streak itself.
    [[nodiscard]] VDBLIC_INLINE Float8 density(const TextureModulation& texture, Float8 stretched) const
    {
        const Float8 rise = stretched * (2 / texture.foot) - 1;
        const Float8 below = rise < 1 ? rise : broadcast8(1);
        const Float8 t = below > 0 ? below : Float8{};
        return strength * t * t * (3 - 2 * t) * (1 - texture.density(stretched));
    }
    /// Factor on the extinction of a flank: 0 where it faces the eye, 1 where it is seen edge-on.
    /// @param facing squared cosine of the angle between its normal and the ray
    [[nodiscard]] VDBLIC_INLINE static Float8 edge(Float8 facing) { return (1 - facing) * (1 - facing); }
};

inline constexpr double kMostChosenOpacity = 0.95; ///< of a voxel, where chosen automatically

/// All that determines a sample's colour and opacity.
struct Look {
    TransferFunction transfer;
    TextureModulation texture;
    Shading shading;
    Halo halo;
    float depthCue = 0;
    float shadows = 0;       ///< see LightGrid
    float occlusion = 0;     ///< see LightGrid
    double exposure = 0;     ///< of the picture [stops], which is applied after the rays (exposed())
    Background background{}; ///< colour that halos and distance fade to

    /// The largest stretched texture that has no opacity, whatever the scalar is; negative: all have one.
    [[nodiscard]] float hiddenStretched() const
    {
        if (texture.strength < 1) return -1;
        return halo.strength > 0 ? texture.foot / 2 : texture.foot;
    }
    /// The same before it is stretched.
    [[nodiscard]] float hiddenTexture() const
    {
        const float hidden = hiddenStretched();
        return hidden < 0 ? -std::numeric_limits<float>::infinity()
                          : texture.low + hidden * (texture.high - texture.low);
    }
    /// The background in linear light before the exposure, for the middle of each of a picture's rows.
    [[nodiscard]] std::vector<glm::vec3> backgroundRows(int count) const;
    /// Whether any sample of a leaf can have an opacity above 0.
    [[nodiscard]] bool contributes(const LeafRange& range) const;
};

/// Choose the unset parameters for unknown data.
///
/// A scalar's range is its 2nd to 99th percentile; the range of a scalar that only opacity follows begins at 0 if it
/// has both signs. Textures are stretched from the 10th to the 98th percentile. Opacity rises with its scalar. It is
/// scaled so that a path as long as `thickness` has the mean optical depth `opticalDepth`: the front is seen, and
/// faintly the depths behind, whatever the volume's size. Where colour tells kinds apart, each has a colour of its own
/// (kinds.h). The exposure compensates the darkening by rims, shadows and light: two thirds of the visible voxels
/// become at least as bright as their colour in the colour bar. It is estimated from samples and look, up to three
/// stops, and depends neither on the camera nor on the frame.
/// @param samples   of one frame or of several
/// @param thickness [voxels], of lines the tubes that are met
/// @param ofLines   whether the texture is the opacity of lines, which is not stretched
/// @throws ParameterError; InputError if there is no sample
[[nodiscard]] Look chooseLook(const LookParams& params, const VolumeSamples& samples, double thickness,
                              bool ofLines = false);

} // namespace vdblic
