#include "vdblic/render/frame_feed.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/render/render_plan.h"

#include <utility>

namespace vdblic {

FrameFeed::FrameFeed(const RenderPlan& plan, std::istream& lines, Reporter& reporter, Exchange& exchange)
    : mPlan(plan), mReporter(reporter), mSource(openSequence(plan.input, lines, mTotal))
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
    const std::optional<FrameFile> file = mSource();
    mHasEnded = !file;
    if (!file) return;
    const RenderOutputs& outputs = mPlan.outputs;
    if (!outputs.film.empty()) checkNotInput(outputs.film, file->path);
    if (!outputs.images.empty()) {
        const FramePattern images(outputs.images);
        checkNotInput(images.path(file->frame), file->path);
        if (mPlan.input.pattern == "-") checkOutput(images.path(file->frame));
        if (mTaken++ == 1) checkOutputPattern(images, 2); // standard input named a second path
    }
    task.file = *file;
    if (mOnlyFrame && mOnlyFrame->file.path == file->path) task.loaded = std::exchange(mOnlyFrame, nullptr);
    if (!mView) {
        task.loaded = std::make_shared<const LoadedTexture>(loadFrame(mPlan.picture, *file));
        if (!task.loaded->empty()) {
            OneProcess alone;
            mView = chooseView(mPlan.picture, {&task.loaded, 1}, task.loaded->box().corners(), {}, alone);
        }
    }
    task.view = view();
}

} // namespace vdblic
