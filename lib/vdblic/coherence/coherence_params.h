#pragma once

#include "vdblic/flow/velocity_sequence_params.h"
#include "vdblic/lic/pathline_params.h"

#include <string>

namespace vdblic {

/// Where a texture is sampled to measure its coherence.
struct CoherenceParams {
    int samples = 100'000;    ///< random points a frame, uniform over the texture's voxels; fewer of them count
    float leastMotion = 0.5f; ///< a point counts where the flow moves at least this far [velocity voxels per step]
    PathlineParams pathline;  ///< in voxels of the texture

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(CoherenceParams& params);

/// Which sequences to measure, and where the results go.
struct SequenceCoherenceParams {
    VelocitySequenceParams flow;
    std::string texture;     ///< file or pattern; its frames are matched to the velocity's by number
    std::string textureName; ///< of the texture's grid; empty: by the files' metadata, else `density`
    CoherenceParams coherence;
    std::string json; ///< file for the figures; empty for none

    void validate() const; ///< @throws ParameterError
};
[[nodiscard]] Parameters parametersOf(SequenceCoherenceParams& params);

} // namespace vdblic
