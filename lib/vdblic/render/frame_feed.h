#pragma once

#include "vdblic/render/moment.h"
#include "vdblic/render/view.h"

#include <cstddef>
#include <exception>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>

namespace vdblic {

class Exchange;
class Reporter;
struct RenderPlan;

/// A picture to make, or an error in place of it.
struct FrameTask {
    Moment moment;
    std::shared_ptr<const LoadedTexture> loaded; ///< if it was read before its turn
    const View* view = nullptr;                  ///< null until a frame has an active voxel
    std::exception_ptr error;
};

/// Gives the frames of a run in order, and chooses the view: of a pattern at once, of paths on standard input by the
/// first frame with an active voxel.
class FrameFeed {
  public:
    /// @param plan, lines, reporter must outlive this
    /// @throws ParameterError, InputError. Collective
    FrameFeed(const RenderPlan& plan, std::istream& lines, Reporter& reporter, Exchange& exchange);

    /// The next frame; nullopt at the end, and after an error that ends the run.
    [[nodiscard]] std::optional<FrameTask> next();
    /// Null if no frame so far has an active voxel.
    [[nodiscard]] const View* view() const { return mView ? &*mView : nullptr; }
    [[nodiscard]] std::size_t total() const { return mTotal; } ///< pictures; 0 if it is unknown

  private:
    void take(FrameTask& task);

    const RenderPlan& mPlan;
    Reporter& mReporter;
    std::size_t mTotal = 0, mTaken = 0;
    std::function<std::optional<Moment>()> mSource;
    std::optional<View> mView;
    std::shared_ptr<const LoadedTexture> mOnlyFrame; // of the sequence, if it was read to choose the view
    bool mHasEnded = false;
};

} // namespace vdblic
