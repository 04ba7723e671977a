#pragma once

#include "vdblic/field/domain_mask.h"
#include "vdblic/io/sequence.h"
#include "vdblic/io/velocity.h"
#include "vdblic/lic/feedback_params.h"
#include "vdblic/lic/lic_kernel.h"
#include "vdblic/lic/scatter_params.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {

/// From a velocity sequence to a texture sequence.
struct AdvectParams {
    SequenceParams input;
    std::string output; ///< pattern of the texture files
    VelocityParams velocity;
    std::optional<double> frameSpacing; ///< seconds between frames on disk; nothing: by metadata, else 1/24
    DomainParams domain;
    ScatterParams scatter;
    FeedbackParams feedback;
    std::optional<LicKernel> steady; ///< LIC of each frame on its own, instead of scatter.method
    std::string noise;               ///< FILE or FILE:GRID; empty: generated from the seed
    std::uint32_t seed = 1;          ///< of the generated noise
    std::optional<int>
        preroll; ///< steps on the frozen first frame before it is written; nothing: the life span, 0 for LIC
    std::string textureName = "density";
    std::vector<std::string> derived{};   ///< further grids made of the velocity, by kDerivedNames
    std::string json{};                   ///< file for the RunReport; empty: none
    bool resume = false;                  ///< go on from the checkpoint that an interrupted run left, if there is one
    std::optional<int> checkpointEvery{}; ///< frames between checkpoints, 0 for none; nothing: CheckpointSchedule's

    void validate() const;                  ///< @throws ParameterError
    [[nodiscard]] int prerollSteps() const; ///< as given, else the default
};

/// The parameters that the outputs tell in their metadata.
[[nodiscard]] openvdb::MetaMap parameterMetadata(const AdvectParams& params);

/// Parameters by the options that set them, as text: `--life`, `4`. Empty where nothing is given.
using ParameterTexts = std::vector<std::pair<std::string, std::string>>;

/// Every parameter that has a say in the outputs' content, but for the input sequence itself; a file's text includes
/// its stamp.
[[nodiscard]] ParameterTexts parameterTexts(const AdvectParams& params);

} // namespace vdblic
