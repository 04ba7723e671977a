#pragma once

#include "vdblic/field/domain.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace vdblic {

/// The texture of a leaf in a step: the mean of the values that hit each voxel, in [0, 1]; a voxel without hits keeps
/// its input, one outside the mask has 0.
///
/// @param hits    Hits words
/// @param input   of the step, fixed-point (kNoiseMax)
/// All have 512 values, x slowest. Thread-safe.
void convolve(const Domain::Mask& mask, const std::int64_t* hits, const std::int32_t* input, float* texture);

/// A leaf of a running mean: 512 values of each, x slowest. Both are null if there is none.
/// @tparam Number float or const float
template<typename Number>
struct MeanLeaf {
    Number *mean = nullptr, *weight = nullptr;
};

/// The texture with substeps: the mean over the last steps, in which hits count less the older they are.
///
/// A single substep moves a pathline by a fraction of a voxel or little more: too few voxels are hit for a texture, and
/// too few hits average to it. With weights that fall by (N − 1) / (N + 1) in each of N substeps the mean age of the
/// hits is half a frame, as it is without substeps.
struct RunningMean {
    LeafValues<float> mean;   ///< in [0, 1]
    LeafValues<float> weight; ///< of the hits that `mean` is of

    [[nodiscard]] MeanLeaf<float> of(std::size_t leaf) { return {mean[leaf], weight[leaf]}; }
    [[nodiscard]] MeanLeaf<const float> of(std::size_t leaf) const { return {mean[leaf], weight[leaf]}; }
};

/// A leaf of the running mean after a step, from the one after the step before. Otherwise as convolve() for one step.
void convolve(const Domain::Mask& mask, const std::int64_t* hits, const std::int32_t* input, int substeps,
              const MeanLeaf<const float>& before, const MeanLeaf<float>& after);

/// The texture of a step, made leaf by leaf as soon as a leaf has all its hits.
class Convolution {
  public:
    /// @param domain, input of the step; must outlive every take()
    /// @param before the running mean after the step before, on the domain; nothing in the first step and without
    ///               substeps
    Convolution(const Domain& domain, const LeafValues<std::int32_t>& input, int substeps,
                std::optional<RunningMean> before);

    /// Threads may take different leaves. @param hits Hits words of an own leaf
    void take(std::size_t leaf, const std::int64_t* hits);

    /// The texture, once every own leaf has been passed to take(); in [0, 1], with room for the halo. Called once.
    [[nodiscard]] LeafValues<float> texture();

    /// The running mean for the step to come, if there are substeps. Called once, after texture().
    /// @param next its domain  @param input of that step: a new voxel has it, without weight
    [[nodiscard]] std::optional<RunningMean> meanOn(const Domain& next, const LeafValues<std::int32_t>& input);

  private:
    const Domain& mDomain;
    const LeafValues<std::int32_t>& mInput;
    int mSubsteps;
    std::optional<RunningMean> mBefore, mAfter;
    LeafValues<float> mTexture; // without substeps
};

} // namespace vdblic
