#pragma once

#include "vdblic/cast/solid.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/image/image_file.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/histogram.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/scene.h"

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace vdblic {

/// The image of a frame and what there is to tell of it.
struct FrameImage {
    Image image; ///< empty without an output; at ranks other than the first only their part
    ImageHeader header;
    bool hasColor = true;
    std::size_t unusableVoxels = 0;
    std::string nothingSeen; ///< why the image shows nothing; empty if it shows something
    std::optional<TextureHistograms> histograms;
};

/// Makes the images of a sequence's frames. Thread-safe for a process alone; several ranks share each frame.
class FrameRenderer {
  public:
    /// @param plan, reporter, exchange must outlive this
    FrameRenderer(const RenderPlan& plan, Reporter& reporter, Exchange& exchange)
        : mPlan(plan), mReporter(reporter), mExchange(exchange)
    {
    }

    /// Collective. @param scene null if no frame so far has an active voxel
    /// @param loaded the frame if it was read before, else null
    /// @throws InputError naming the file; Stopped
    [[nodiscard]] FrameImage render(const FrameFile& file, const Scene* scene,
                                    std::shared_ptr<const LoadedTexture> loaded) const;

  private:
    [[nodiscard]] std::shared_ptr<const Solid> solidOf(const LoadedTexture& frame) const;

    const RenderPlan& mPlan;
    Reporter& mReporter;
    Exchange& mExchange;
    mutable std::once_flag mSolidMade;
    mutable std::shared_ptr<const Solid> mSolid;
};

} // namespace vdblic
