#pragma once

#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/solid.h"
#include "vdblic/core/exchange.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/view.h"
#include "vdblic/volume/visible_space.h"

#include <memory>
#include <optional>

namespace vdblic {

/// A frame as a look shows it, without what depends on the camera: pictures from several eyes share it. Immutable; any
/// number of threads may read.
class ShownVolume {
  public:
    /// @param look  of the pictures
    /// @param solid or null
    /// @param exchange of the ranks that cast pictures together, for which the frame was loaded: collective
    ShownVolume(const PicturePlan& plan, const Look& look, std::shared_ptr<const LoadedTexture> frame,
                std::shared_ptr<const Solid> solid, Exchange& exchange);

    [[nodiscard]] const LoadedTexture& frame() const { return *mFrame; }
    [[nodiscard]] const TextureVolume& volume() const { return mFrame->volume; }
    [[nodiscard]] const Solid* solid() const { return mSolid.get(); }
    [[nodiscard]] const VisibleSpace& visible() const { return mVisible; }
    /// Null if nothing casts a shadow or occludes.
    [[nodiscard]] const ExtinctionGrid* extinctions() const { return mExtinctions ? &*mExtinctions : nullptr; }
    /// Null if the look has neither shadows nor occlusion.
    [[nodiscard]] const AmbientLight* ambient() const { return mAmbient ? &*mAmbient : nullptr; }

  private:
    std::shared_ptr<const LoadedTexture> mFrame;
    std::shared_ptr<const Solid> mSolid;
    VisibleSpace mVisible;
    std::optional<ExtinctionGrid> mExtinctions;
    std::optional<AmbientLight> mAmbient;
};

} // namespace vdblic
