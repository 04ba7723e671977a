#pragma once

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
    int taps = 2;      ///< AUFLIC: samples to each side of the mean along the flow that is taken first
    float sharpen = 1; ///< strength s of c + s (c − mean of the 26 neighbours)
    Jitter jitter = Jitter::kMix;
    float noiseShare = 0.1f; ///< kMix: share of the original noise, 0 to 1
    float deviation = 0.25f; ///< kMix: standard deviation that local contrast is restored to; uniform noise has 0.289

    void validate() const; ///< @throws ParameterError

    /// The same with more contrast, which the mean along the flow takes away again.
    [[nodiscard]] FeedbackParams beforeMean() const
    {
        FeedbackParams params = *this;
        params.deviation *= 1.08f;
        return params;
    }
};

} // namespace vdblic
