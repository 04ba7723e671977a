#pragma once

#include "vdblic/field/velocity_field.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace vdblic {

/// How noise is mixed into the sharpened texture before it becomes the next input.
enum class Jitter {
    kMix,  ///< linear: local contrast restored to a fixed deviation, then a share of the original noise
    kBits, ///< the top bit from the texture, the lower bits from the original noise, ends stretched
};

[[nodiscard]] Jitter parseJitter(std::string_view text); ///< `mix` or `bits`. @throws ParameterError
[[nodiscard]] std::string_view toString(Jitter jitter);

/// The noise-jittered high-pass filter between a texture and the next step's input.
struct FeedbackParams {
    float sharpen = 1; ///< strength s of c + s (c − mean of the 26 neighbours)
    Jitter jitter = Jitter::kMix;
    float noiseShare = 0.1f; ///< kMix: share of the original noise, 0 to 1
    float deviation = 0.22f; ///< kMix: standard deviation that local contrast is restored to; uniform noise has 0.289

    void validate() const; ///< @throws ParameterError
};

/// The original noise: values 0 to 65535 for every voxel of index space.
///
/// Where a grid has an active voxel its value in [0, 1] counts, elsewhere the noise is generated from the seed.
/// Immutable; any number of threads may read.
class NoiseField {
  public:
    explicit NoiseField(std::uint32_t seed, openvdb::FloatGrid::ConstPtr grid = nullptr)
        : mSeed(seed), mGrid(std::move(grid))
    {
    }

    /// The 512 values of a leaf, x slowest.
    void fill(const openvdb::Coord& origin, std::int32_t* values) const;

    /// What fluid that enters the domain in a voxel brings with it: noise that is new in every step.
    [[nodiscard]] std::int32_t entering(const openvdb::Coord& voxel, std::uint64_t step) const;
    /// Whether a voxel takes it in a step: at random, as often as fluid comes from outside.
    /// @param stayed the part of the voxel's fluid, 0 to 1, that was inside a step ago
    [[nodiscard]] bool fromOutside(const openvdb::Coord& voxel, std::uint64_t step, float stayed) const;

  private:
    [[nodiscard]] std::int32_t ofStep(const openvdb::Coord& voxel, std::uint64_t number) const;

    std::uint32_t mSeed;
    openvdb::FloatGrid::ConstPtr mGrid;
};

/// The noise on a domain, as the first step's input.
[[nodiscard]] LeafValues<std::int32_t> noiseInput(const Domain& domain, const NoiseField& noise);

/// The texture of a step: mean of the values each voxel was hit by, in [0, 1]; a voxel without hits keeps its input.
[[nodiscard]] LeafValues<float> convolve(const Domain& domain, const LeafValues<std::int64_t>& accumulator,
                                         const LeafValues<std::int32_t>& input);

/// The next step's input: the texture sharpened, carried on to the next frame's time, and jittered.
///
/// The texture is the mean over a step, so what it shows stands where the fluid was half a step before the next frame:
/// the input of a voxel is the sharpened texture half a step upstream. Fed back in place, features would lag behind the
/// flow (docs/algorithm.md).
///
/// A voxel that is new in the next domain takes the original noise. Where fluid enters the
/// domain it brings noise that is new in every step; a voxel takes it as often as its fluid was outside a step ago.
/// Nothing flows there but the voxel's own values, and fed back they would freeze into streaks as long as the domain.
///
/// @param field   velocity over the step that made the texture
/// @param texture in [0, 1], on the field's domain
/// @param next    domain of the step to come
/// @param step    number of the step that made the texture
/// @return values 0 to 65535 on `next`. The result does not depend on the number of threads.
/// Shen & Kao 1998, section 3.3; Liu & Moorhead 2004, section 1.
[[nodiscard]] LeafValues<std::int32_t> feedForward(const VelocityField& field, const LeafValues<float>& texture,
                                                   const Domain& next, const NoiseField& noise,
                                                   const FeedbackParams& params, std::uint64_t step);

} // namespace vdblic
