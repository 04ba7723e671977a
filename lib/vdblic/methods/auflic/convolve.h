#pragma once

#include "vdblic/field/domain.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace vdblic {

/// The texture of a leaf in a step: the mean of the values that hit each voxel, in [0, 1]. A voxel without hits keeps
/// its input; one outside the mask is 0.
///
/// @param hits    Hits words
/// @param input   of the step, fixed-point (kNoiseMax)
/// All arrays have 512 values, x slowest. Thread-safe.
void convolve(const Domain::Mask& mask, const std::int64_t* hits, const std::int32_t* input, float* texture);

/// A leaf of a running mean: 512 values each, x slowest. Both are null without a mean.
/// @tparam Number float or const float
template<typename Number>
struct MeanLeaf {
    Number *mean = nullptr, *weight = nullptr;
};

/// The texture with substeps: the mean over the last steps, with weights that decrease with the age of the hits.
///
/// A substep moves a pathline by about a voxel or less: too few voxels are hit, too rarely for a smooth mean. With
/// weights that fall by a factor of (N − 1) / (N + 1) in each of N substeps the mean age of the hits is half a frame,
/// as without substeps.
struct RunningMean {
    LeafValues<float> mean;   ///< in [0, 1]
    LeafValues<float> weight; ///< of the hits in `mean`

    [[nodiscard]] MeanLeaf<float> of(std::size_t leaf) { return {mean[leaf], weight[leaf]}; }
    [[nodiscard]] MeanLeaf<const float> of(std::size_t leaf) const { return {mean[leaf], weight[leaf]}; }
};

/// A leaf of the running mean after a step, from the mean before it. Otherwise as convolve() for one step.
void convolve(const Domain::Mask& mask, const std::int64_t* hits, const std::int32_t* input, int substeps,
              const MeanLeaf<const float>& before, const MeanLeaf<float>& after);

/// The texture of a step, computed for each leaf once it has all its hits.
class Convolution {
  public:
    /// @param domain, input of the step; must outlive every take()
    /// @param before the running mean before the step, on the domain; nothing in the first step and without substeps
    Convolution(const Domain& domain, const LeafValues<std::int32_t>& input, int substeps,
                std::optional<RunningMean> before);

    /// Threads may pass different leaves. @param hits Hits words of an own leaf
    void take(std::size_t leaf, const std::int64_t* hits);

    /// The texture, once every own leaf has been passed to take(); in [0, 1], with room for the halo. Called once.
    [[nodiscard]] LeafValues<float> texture();

    /// The running mean for the next step, with substeps. Called once, after texture().
    /// @param next its domain  @param input of that step: the value, with weight 0, of new voxels
    [[nodiscard]] std::optional<RunningMean> meanOn(const Domain& next, const LeafValues<std::int32_t>& input);

  private:
    const Domain& mDomain;
    const LeafValues<std::int32_t>& mInput;
    int mSubsteps;
    std::optional<RunningMean> mBefore, mAfter;
    LeafValues<float> mTexture; // without substeps
};

} // namespace vdblic
