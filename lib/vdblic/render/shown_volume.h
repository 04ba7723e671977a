#pragma once

#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/solid.h"
#include "vdblic/cast/tube_tree.h"
#include "vdblic/core/exchange.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/view.h"
#include "vdblic/volume/visible_space.h"

#include <memory>
#include <optional>

namespace vdblic {

/// The camera-independent data of a frame under a look: pictures from several eyes share it. Immutable; any number of
/// threads may read.
class ShownVolume {
  public:
    /// @param look  of the pictures
    /// @param solid or null
    /// @param linesLook of the lines in the voxels; null: they are not drawn
    /// @param exchange of the ranks that cast pictures together, for which the frame was loaded: collective
    ShownVolume(const PicturePlan& plan, const Look& look, std::shared_ptr<const LoadedTexture> frame,
                std::shared_ptr<const Solid> solid, Exchange& exchange, const Look* linesLook = nullptr);

    [[nodiscard]] const LoadedTexture& frame() const { return *mFrame; }
    [[nodiscard]] const Solid* solid() const { return mSolid.get(); }
    /// Of voxels; null for lines.
    [[nodiscard]] const VisibleSpace* visible() const { return mVisible ? &*mVisible : nullptr; }
    /// Of lines, also in voxels; or null.
    [[nodiscard]] const TubeTree* tree() const { return mTree ? &*mTree : nullptr; }
    /// Null if the look has neither shadows nor occlusion, and there is no ground.
    [[nodiscard]] const ExtinctionGrid* extinctions() const { return mExtinctions ? &*mExtinctions : nullptr; }
    /// Null if the look has neither shadows nor occlusion.
    [[nodiscard]] const AmbientLight* ambient() const { return mAmbient ? &*mAmbient : nullptr; }

  private:
    std::shared_ptr<const LoadedTexture> mFrame;
    std::shared_ptr<const Solid> mSolid;
    std::optional<VisibleSpace> mVisible;
    std::optional<TubeTree> mTree;
    std::optional<ExtinctionGrid> mExtinctions;
    std::optional<AmbientLight> mAmbient;
};

} // namespace vdblic
