#include "vdblic/render/run_report.h"

#include "vdblic/cast/solid.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/look/transfer_file.h"
#include "vdblic/render/frames_in_flight.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/view.h"

#include <fmt/format.h>

#include <exception>

namespace vdblic {

RunReport::RunReport(const RenderPlan& plan, Reporter& reporter, std::size_t total)
    : mPlan(plan), mReporter(reporter), mTotal(total)
{
    for (const std::string& line : plan.choices)
        reporter.detail(line);
}

void RunReport::tellView(const View& view)
{
    const TransferParams& given = mPlan.picture.look.transfer;
    if (mPlan.input.pattern == "-" && (!given.range || given.opacity.empty())) {
        mReporter.say("range and opacity are chosen from the first frame alone; `transfer` takes them from a file, "
                      "which `transfer_out` writes for a whole sequence");
    }
    if (mPlan.outputs.transferFunction.empty()) return;
    if (writeTransferFile(mPlan.outputs.transferFunction, view.look.transfer.params()))
        mReporter.finished(mPlan.outputs.transferFunction);
}

void RunReport::tellPicture(const RenderedFrame& frame)
{
    if (!mPlan.outputs.images.empty() && !frame.error)
        mReporter.finished(FramePattern(mPlan.outputs.images).path(frame.moment.number));
}

void RunReport::add(const RenderedFrame& frame, const Exchange& exchange)
{
    if (frame.error) return leaveOut(frame);
    const std::string path = frame.moment.file.path.string();
    if (frame.view && !mDescribed) describe(*frame.view, frame.moment.file.frame, exchange);
    if (!frame.hasColor && !mSaidNoColor) {
        mReporter.say(fmt::format("{}: no float grid '{}'; the texture chooses {} instead", path, mPlan.picture.colorBy,
                                  mPlan.picture.opacityBy.empty() ? "colour and opacity" : "the colour"));
        mSaidNoColor = true;
    }
    if (frame.unusableVoxels > 0) {
        mReporter.warn(
            fmt::format("{}: {} values are not finite numbers and are left out", path, frame.unusableVoxels));
    }
    if (frame.leftOut > kMostSolid && !mSaidCloud) {
        mReporter.say(fmt::format("{}: `solid` domain makes {:.0f} % of the texture's box a body, as around a cloud; "
                                  "leave it out where that is air",
                                  path, 100 * frame.leftOut));
        mSaidCloud = true;
    }
    if (frame.histograms && frame.view) {
        if (!mHistograms) mHistograms.emplace(frame.view->look);
        mHistograms->add(*frame.histograms);
    }
    if (frame.wasDamaged) {
        mReporter.warn(fmt::format("{}: was there, but cannot be read as an image; it was made again",
                                   FramePattern(mPlan.outputs.images).path(frame.moment.number).string()));
    }
    mSkipped += frame.skipped ? 1 : 0;
    mRendered += frame.skipped ? 0 : 1;
    mEmptyImages += frame.nothingSeen.empty() ? 0 : 1;
    mNothingSeen = frame.nothingSeen;
    tellPicture(frame);
    mReporter.progress(++mDone, mTotal);
}

/// A frame that cannot be read ends the run, or is left out.
void RunReport::leaveOut(const RenderedFrame& frame)
{
    try {
        std::rethrow_exception(frame.error);
    } catch (const InputError& error) {
        if (!mPlan.keepGoing) throw;
        mReporter.warn(fmt::format("{}; the frame is left out", error.what()));
        ++mLeftOut;
        mReporter.progress(++mDone, mTotal);
    }
}

void RunReport::describe(const View& view, std::int64_t frame, const Exchange& exchange)
{
    mDescribed = true;
    if (mPlan.input.pattern == "-") tellView(view);
    const Look& look = view.look;
    const Camera camera = view.cameras.at(double(frame));
    mReporter.detail(fmt::format("frame {}: {} from {} to {}, up {}", frame, nameOf(camera.projection()),
                                 vectorText(camera.eye()), vectorText(camera.target()), vectorText(camera.up())));
    const TransferFunction& transfer = look.transfer;
    mReporter.detail(fmt::format("{} {} to {} ({}), opacity by {} {} to {} ({}): {}, texture {} to {}, exposure {}",
                                 mPlan.picture.colorBy, transfer.range()[0], transfer.range()[1],
                                 nameOf(transfer.colorAxis().scale), view.opacityBy, transfer.opacityRange()[0],
                                 transfer.opacityRange()[1], nameOf(transfer.opacityAxis().scale),
                                 opacityText(transfer.opacity()), look.texture.low, look.texture.high, look.exposure));
    if (view.lines) {
        const TransferFunction& lines = view.lines->look.transfer;
        mReporter.say(fmt::format("lines: colours of {} {:.4g} to {:.4g}, opacity by {} {:.4g} to {:.4g}",
                                  mPlan.picture.colorBy, lines.range()[0], lines.range()[1], view.lines->opacityBy,
                                  lines.opacityRange()[0], lines.opacityRange()[1]));
    }
    const std::string which = exchange.isAlone() ? fmt::format("{} frames at once", framesInFlight(view.frameBytes))
                                                 : fmt::format("each frame by {} ranks", exchange.size());
    mReporter.detail(fmt::format("{}, about {:.0f} MB each", which, view.frameBytes / 1e6));
}

void RunReport::finish(const View* view)
{
    warnOfNothing(view);
    if (view && !view->lines && !mPlan.picture.lines.empty())
        mReporter.warn(fmt::format("{}: no frame has a line to show; the texture is drawn alone", mPlan.picture.lines));
    if (!mPlan.outputs.histogram.empty()) writeHistogram(view);
    if (mPlan.outputs.skipExisting) mReporter.say(fmt::format("{} of {} images were there already", mSkipped, mDone));
    if (mLeftOut == 0) return;
    throw InputError(fmt::format("{} of {} frames could not be rendered; the warnings name them", mLeftOut, mDone));
}

void RunReport::warnOfNothing(const View* view)
{
    const bool hasPictures = !mPlan.outputs.images.empty() || !mPlan.outputs.film.empty();
    if (!view) {
        if (mLeftOut < mDone) mReporter.warn("no frame has an active voxel; there is nothing to see");
    } else if (hasPictures && mRendered > 0 && mRendered == mEmptyImages) {
        mReporter.warn("the images show nothing: " + mNothingSeen);
    }
}

void RunReport::writeHistogram(const View* view)
{
    if (!mHistograms) throw InputError("no active voxel was met; there is nothing to make histograms of");
    const ScalarNames names{mPlan.picture.colorBy, view->opacityBy};
    if (writeHistograms(mPlan.outputs.histogram, *mHistograms, view->look, names))
        mReporter.finished(mPlan.outputs.histogram);
}

} // namespace vdblic
