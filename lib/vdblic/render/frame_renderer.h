#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/image/image_file.h"
#include "vdblic/look/histogram.h"
#include "vdblic/render/moment.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/view.h"

#include <cstddef>
#include <exception>
#include <memory>
#include <optional>
#include <string>

namespace vdblic {

/// The report on a rendered frame, without the image; or its error.
struct RenderedFrame {
    Moment moment;
    const View* view = nullptr; ///< null if no frame so far has an active voxel
    bool hasColor = true;
    std::size_t unusableVoxels = 0;
    double leftOut = 0;        ///< share of the frame's box inside the solid `domain`
    std::string nothingSeen{}; ///< why the image shows nothing; else an empty text
    std::optional<TextureHistograms> histograms{};
    bool skipped = false, wasDamaged = false; ///< the image that was there
    std::string film{};                       ///< displayBytes() of the image, for a film
    std::exception_ptr error{};
};

/// The image of a frame; without images and film empty, at ranks other than the first only their part.
struct FrameImage {
    Image image;
    ImageHeader header;
};

/// Makes the images of a sequence's frames. Thread-safe for a process alone; several ranks share each frame.
class FrameRenderer {
  public:
    /// @param plan, reporter, exchange must outlive this
    FrameRenderer(const RenderPlan& plan, Reporter& reporter, Exchange& exchange)
        : mPlan(plan), mReporter(reporter), mExchange(exchange)
    {
    }

    /// Collective.
    /// @param loaded the frame if it was read before, else null
    /// @param frame  with its moment and view; receives the report
    /// @throws InputError naming the file; Stopped
    [[nodiscard]] FrameImage render(std::shared_ptr<const LoadedTexture> loaded, RenderedFrame& frame) const;

  private:
    const RenderPlan& mPlan;
    Reporter& mReporter;
    Exchange& mExchange;
};

} // namespace vdblic
