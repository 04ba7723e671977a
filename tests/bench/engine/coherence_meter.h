#pragma once

#include "bench/engine/figures.h"
#include "bench/engine/flow.h"
#include "vdblic/coherence/smoothed_texture.h"

#include <cstddef>
#include <optional>

namespace vdblic::bench {

/// Measures the coherence of successive textures of a flow.
class CoherenceMeter {
  public:
    /// @param k frame of the texture @param figures receives those of the frame before
    void add(const Flow& flow, std::size_t k, const LeafValues<float>& texture, Figures& figures);

  private:
    std::optional<SmoothedTexture> mLast;
};

} // namespace vdblic::bench
