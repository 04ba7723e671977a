#pragma once

#include "vdblic/look/histogram.h"
#include "vdblic/render/frame_renderer.h"

#include <cstddef>
#include <optional>
#include <string>

namespace vdblic {

class Exchange;
class Reporter;
struct RenderPlan;
struct View;

/// Messages and counts of a run, and the reports on all its frames.
class RunReport {
  public:
    /// @param plan, reporter must outlive this  @param total frames; 0 if it is unknown
    RunReport(const RenderPlan& plan, Reporter& reporter, std::size_t total);

    /// The view is chosen: write its transfer function.
    void tellView(const View& view);
    /// A frame is done, in order. @param exchange of the ranks that share it
    /// @throws the frame's error unless the run leaves such frames out
    void add(const RenderedFrame& frame, const Exchange& exchange);
    /// Every picture on disk is reported, even after errors in earlier frames.
    void tellPicture(const RenderedFrame& frame);
    /// All frames are done. @param view null if no frame has an active voxel
    /// @throws InputError if frames are missing; OutputError
    void finish(const View* view);

  private:
    void describe(const View& view, std::int64_t frame, const Exchange& exchange);
    void leaveOut(const RenderedFrame& frame);
    void writeHistogram(const View* view);
    void warnOfNothing(const View* view);

    const RenderPlan& mPlan;
    Reporter& mReporter;
    std::optional<TextureHistograms> mHistograms;
    std::size_t mTotal, mDone = 0, mSkipped = 0, mLeftOut = 0, mRendered = 0, mEmptyImages = 0;
    std::string mNothingSeen; // why the last image shows nothing
    bool mDescribed = false, mSaidNoColor = false, mSaidCloud = false;
};

} // namespace vdblic
