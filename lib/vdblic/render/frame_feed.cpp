#include "vdblic/render/frame_feed.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/render/render_plan.h"

#include <filesystem>
#include <utility>

namespace vdblic {

FrameFeed::FrameFeed(const RenderPlan& plan, std::istream& lines, Reporter& reporter, Exchange& exchange)
    : mPlan(plan), mReporter(reporter), mSource(openMoments(plan, lines, mTotal))
{
    if (plan.input.pattern == "-") return;
    std::optional<SequenceView> found = viewOfSequence(plan, exchange);
    if (!found) return;
    mView = std::move(found->view);
    mOnlyFrame = std::move(found->onlyFrame);
}

std::optional<FrameTask> FrameFeed::next()
{
    if (mHasEnded) return std::nullopt;
    FrameTask task;
    try {
        take(task);
    } catch (const InputError&) {
        task.error = std::current_exception();
        mHasEnded = !mPlan.keepGoing;
        return task;
    } catch (...) {
        task.error = std::current_exception();
        mHasEnded = true;
        return task;
    }
    if (mHasEnded) return std::nullopt;
    return task;
}

void FrameFeed::take(FrameTask& task)
{
    mReporter.checkStop();
    const std::optional<Moment> moment = mSource();
    mHasEnded = !moment;
    if (!moment) return;
    const std::filesystem::path& path = moment->file.path;
    const RenderOutputs& outputs = mPlan.outputs;
    if (!outputs.film.empty()) checkNotInput(outputs.film, path);
    if (!outputs.images.empty()) {
        const FramePattern images(outputs.images);
        const std::filesystem::path image = images.path(moment->number);
        checkNotInput(image, path);
        if (mPlan.input.pattern == "-") checkOutput(image);
        if (mTaken++ == 1) checkOutputPattern(images, 2); // standard input named a second path
    }
    task.moment = *moment;
    if (mOnlyFrame && mOnlyFrame->file.path == path) task.loaded = std::exchange(mOnlyFrame, nullptr);
    if (!mView) {
        task.loaded = std::make_shared<const LoadedTexture>(loadFrame(mPlan.picture, *moment));
        if (!task.loaded->empty()) {
            OneProcess alone;
            mView = chooseView(mPlan.picture, {&task.loaded, 1}, task.loaded->box().corners(), {}, alone);
        }
    }
    task.view = view();
}

} // namespace vdblic
