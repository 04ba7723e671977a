#pragma once

#include "vdblic/cast/ground.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/ray_cast_params.h"
#include "vdblic/cast/supersampling.h"
#include "vdblic/core/exchange.h"
#include "vdblic/image/image_file.h"
#include "vdblic/render/picture_share.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/shown_volume.h"
#include "vdblic/render/view.h"

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

namespace vdblic {

/// The picture of a frame, refined by every sample, with annotations.
class Picture {
  public:
    /// @param plan, view, share must outlive this
    /// @param shown  the frame with the view's look
    /// @param share  of the ranks that cast this picture together, for which the frame was loaded; or null. Collective
    Picture(const PicturePlan& plan, const View& view, std::shared_ptr<const ShownVolume> shown,
            const PictureShare* share = nullptr);
    Picture(const Picture&) = delete;
    Picture& operator=(const Picture&) = delete;

    /// Cast the next ray of every pixel. @throws Stopped, with the picture as it was, if a stop is requested
    void addSample(const std::stop_token& stop = {}) { mSum->add(stop); }
    [[nodiscard]] int samples() const { return mSum->count(); }

    /// The picture of at least one sample, with annotations; at ranks other than the first only their part, without.
    /// Collective.
    [[nodiscard]] Image image() const;
    [[nodiscard]] ImageHeader header() const;
    /// Why the image shows nothing; else an empty text. Collective.
    [[nodiscard]] std::string whyNothingIsSeen(const Image& image);
    [[nodiscard]] const Camera& camera() const { return mCamera; }

  private:
    const PicturePlan& mPlan;
    const View& mView;
    std::shared_ptr<const ShownVolume> mShown;
    const PictureShare* mShare;
    OneProcess mAlone;
    Exchange& mExchange; // of the share, else this process alone
    RayCastParams mRays; // with the cuts in the volume's space
    Camera mCamera;
    std::optional<LightGrid> mLight;
    std::optional<Ground> mGround;
    std::optional<SampleSum> mSum;
};

} // namespace vdblic
