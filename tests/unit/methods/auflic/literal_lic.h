#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/flow/velocity_frame.h"
#include "vdblic/methods/texture_params.h"

#include <vector>

namespace vdblic::test {

/// UFLIC and AUFLIC literally as in the paper, slowly: scattering process (SCAP) after scattering process, each seed
/// carried through its whole life span at once into a ring of L buckets, seed by seed and deposit by deposit.
///
/// Shares only the noise and the containers with the library: literal_path.h has the pathlines, literal_filter.h the
/// filters.
std::vector<LeafValues<float>> literalTextures(const std::vector<VelocityFrame>& frames, int steps,
                                               const TextureParams& scatter);

/// AUFLIC with history, slowly: particle after particle and deposit after deposit, all in maps.
std::vector<LeafValues<float>> literalTexturesWithHistory(const std::vector<VelocityFrame>& frames, int steps,
                                                          const TextureParams& scatter);

} // namespace vdblic::test
