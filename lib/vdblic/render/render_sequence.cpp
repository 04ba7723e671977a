#include "vdblic/render/render_sequence.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/memory.h"
#include "vdblic/image/film_writer.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/image/whole_image.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/look/histogram.h"
#include "vdblic/look/transfer_file.h"
#include "vdblic/render/annotation_font.h"
#include "vdblic/render/frame_renderer.h"
#include "vdblic/render/frames_in_flight.h"
#include "vdblic/render/render_outputs.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/scene.h"

#include <fmt/format.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <istream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// A frame to render, or an error in place of it.
struct FrameTask {
    FrameFile file;
    std::shared_ptr<const LoadedTexture> loaded; ///< if it was read before its turn
    const Scene* scene = nullptr;                ///< null until a frame has an active voxel
    std::exception_ptr error;
};

/// A frame whose image is on disk, or an error.
struct RenderedFrame {
    FrameFile file;
    const Scene* scene = nullptr;
    FrameImage made;                          ///< without the image
    bool skipped = false, wasDamaged = false; ///< the image that was there
    std::string film;                         ///< the picture as displayed
    std::exception_ptr error;
};

/// The run over a sequence: frames are taken one by one, rendered in parallel, and reported one by one in order.
class SequenceRenderer {
  public:
    SequenceRenderer(const RenderPlan& plan, std::istream& lines, Reporter& reporter, Exchange& exchange)
        : mPlan(plan), mReporter(reporter), mExchange(exchange), mRenderer(mPlan, reporter, exchange),
          mSource(openSequence(plan.input, lines, mTotal))
    {
        const bool isPiped = plan.input.pattern == "-";
        const std::vector<FrameFile> files = isPiped ? std::vector<FrameFile>{} : selectFrames(plan.input);
        checkRenderOutputs(plan, files);
        if (!plan.outputs.images.empty()) mOutput.emplace(plan.outputs.images);
        if (!plan.outputs.film.empty())
            mFilm.emplace(plan.outputs.film, plan.picture.scaledSize(), plan.outputs.framesPerSecond);
    }

    void run()
    {
        if (mPlan.input.pattern != "-") {
            if (std::optional<SequenceScene> found = sceneOfSequence(mPlan, mExchange)) {
                mScene = std::move(found->scene);
                mOnlyFrame = std::move(found->onlyFrame);
            }
            if (mScene) tellTransfer();
            if (!mOutput && !mFilm && mPlan.outputs.histogram.empty()) return checkScene();
        }
        warnOfTitle();
        mReporter.progress(0, mTotal);
        if (mExchange.isAlone()) {
            // How many frames fit in memory is known once one has been read.
            if (!mScene) runPipeline(1, /*untilScene=*/true);
            runPipeline(framesInFlight(mScene ? mScene->frameBytes : 1), /*untilScene=*/false);
        } else {
            for (FrameTask task; take(task); task = {})
                report(finish(task));
        }
        mReporter.checkStop(); // a request to stop ends standard input
        if (mDone == 0) throw InputError("no frame to render: standard input named none");
        if (mFilm) {
            mFilm->finish();
            mReporter.finished(mPlan.outputs.film);
        }
        warnOfNothing();
        if (!mPlan.outputs.histogram.empty()) writeHistogram();
        if (mPlan.outputs.skipExisting)
            mReporter.say(fmt::format("{} of {} images were there already", mSkipped, mDone));
        if (mLeftOut == 0) return;
        throw InputError(fmt::format("{} of {} frames could not be rendered; the warnings name them", mLeftOut, mDone));
    }

  private:
    void writeHistogram()
    {
        if (!mHistograms) throw InputError("no active voxel was met; there is nothing to make histograms of");
        const ScalarNames names{mPlan.picture.colorBy, mScene->opacityBy};
        if (writeHistograms(mPlan.outputs.histogram, *mHistograms, mScene->look, names))
            mReporter.finished(mPlan.outputs.histogram);
    }

    void checkScene() const
    {
        if (!mScene) throw InputError(fmt::format("{}: no frame has an active voxel", mPlan.input.pattern));
    }

    /// What the look was chosen from, and its transfer function.
    void tellTransfer()
    {
        const TransferParams& given = mPlan.picture.look.transfer;
        if (mPlan.input.pattern == "-" && (!given.range || given.opacity.empty())) {
            mReporter.say("range and opacity are chosen from the first frame alone; `transfer` takes them from a file, "
                          "which `transfer_out` writes for a whole sequence");
        }
        if (mPlan.outputs.transferFunction.empty()) return;
        if (writeTransferFile(mPlan.outputs.transferFunction, mScene->look.transfer.params()))
            mReporter.finished(mPlan.outputs.transferFunction);
    }

    void warnOfTitle()
    {
        const std::string& title = mPlan.picture.annotations.title;
        const std::string missing = title.empty() ? "" : annotationFont(title).missing;
        if (missing.empty()) return;
        mReporter.warn(fmt::format("title '{}': no installed font has '{}', which is drawn as boxes; install one, such "
                                   "as the package fonts-noto-cjk for Chinese, Japanese and Korean",
                                   title, missing));
    }

    void warnOfNothing()
    {
        if (!mScene) {
            if (mLeftOut < mDone) mReporter.warn("no frame has an active voxel; there is nothing to see");
        } else if ((mOutput || mFilm) && mRendered > 0 && mRendered == mEmptyImages) {
            mReporter.warn("the images show nothing: " + mNothingSeen);
        }
    }

    /// @param untilScene end once a frame has an active voxel
    void runPipeline(std::size_t frames, bool untilScene)
    {
        const auto next = [&](tbb::flow_control& flow) {
            FrameTask task;
            if ((untilScene && mScene) || !take(task)) flow.stop();
            return task;
        };
        const auto work = [&](const FrameTask& task) { return finish(task); };
        // An exception that left the pipeline would cancel OpenVDB's work on other frames, and OpenVDB crashes on
        // half-built trees. So it is thrown once the pipeline is empty.
        const auto tell = [&](const RenderedFrame& frame) {
            try {
                mError ? tellPicture(frame) : report(frame);
            } catch (...) {
                mError = std::current_exception();
                mStopped = true;
            }
        };
        using tbb::filter_mode;
        tbb::parallel_pipeline(frames, tbb::make_filter<void, FrameTask>(filter_mode::serial_in_order, next) &
                                           tbb::make_filter<FrameTask, RenderedFrame>(filter_mode::parallel, work) &
                                           tbb::make_filter<RenderedFrame, void>(filter_mode::serial_in_order, tell));
        if (mError) std::rethrow_exception(mError);
    }

    /// Take the next frame; false at the end and after an error.
    bool take(FrameTask& task)
    {
        if (mStopped) return false;
        try {
            mReporter.checkStop();
            const std::optional<FrameFile> file = mSource();
            if (!file) return false;
            if (mOutput) checkNotInput(mOutput->path(file->frame), file->path);
            if (mFilm) checkNotInput(mPlan.outputs.film, file->path);
            if (mOutput && mPlan.input.pattern == "-") checkOutput(mOutput->path(file->frame));
            if (mTaken++ == 1 && mOutput) checkOutputPattern(*mOutput, 2); // standard input named a second path
            task.file = *file;
            if (mOnlyFrame && mOnlyFrame->file.path == file->path) task.loaded = std::exchange(mOnlyFrame, nullptr);
            if (!mScene) {
                task.loaded = std::make_shared<const LoadedTexture>(loadFrame(mPlan.picture, *file));
                if (!task.loaded->volume.empty()) {
                    OneProcess alone;
                    mScene = chooseScene(mPlan.picture, {&task.loaded, 1}, task.loaded->volume.corners(), {}, alone);
                }
            }
            if (mScene) task.scene = &*mScene;
        } catch (const InputError&) {
            task.error = std::current_exception();
            mStopped = !mPlan.keepGoing;
        } catch (...) {
            task.error = std::current_exception();
            mStopped = true;
        }
        return true;
    }

    /// Render a frame and write its image. An error waits for the frame's turn: the frames before it are still
    /// reported.
    RenderedFrame finish(const FrameTask& task) const
    {
        RenderedFrame result{task.file, task.scene};
        try {
            mExchange.together([&] {
                if (task.error) std::rethrow_exception(task.error);
                const bool isThere = mOutput && mPlan.outputs.skipExisting && mExchange.isFirst() &&
                                     isFinished(mOutput->path(task.file.frame));
                const bool isWhole = isThere && isWholeImage(mOutput->path(task.file.frame));
                result.wasDamaged = isThere && !isWhole;
                result.skipped = mExchange.any(isWhole);
                if (result.skipped) return;
                // While a thread waits for this frame's tiles, it must not start to wait for the next path.
                tbb::this_task_arena::isolate([&] { render(task, result); });
            });
        } catch (...) {
            result.error = std::current_exception();
        }
        return result;
    }

    void render(const FrameTask& task, RenderedFrame& result) const
    {
        FrameImage made = mRenderer.render(task.file, task.scene, task.loaded);
        if (mFilm) result.film = displayBytes(made.image, mPlan.picture.background);
        if (mOutput && mExchange.isFirst())
            writeImage(mOutput->path(task.file.frame), made.image, made.header, mPlan.picture.background,
                       mPlan.outputs.exr);
        made.image = {};
        result.made = std::move(made);
    }

    /// A picture that is on disk is told of, whatever happened to the frames before it.
    void tellPicture(const RenderedFrame& frame)
    {
        if (mOutput && !frame.error) mReporter.finished(mOutput->path(frame.file.frame));
    }

    void report(const RenderedFrame& frame)
    {
        if (frame.error) return leaveOut(frame);
        const std::string path = frame.file.path.string();
        if (frame.scene && !mDescribed) describe(*frame.scene, frame.file.frame);
        if (!frame.made.hasColor && !mSaidNoColor) {
            mReporter.say(fmt::format("{}: no float grid '{}'; the texture chooses {} instead", path,
                                      mPlan.picture.colorBy,
                                      mPlan.picture.opacityBy.empty() ? "colour and opacity" : "the colour"));
            mSaidNoColor = true;
        }
        if (frame.made.unusableVoxels > 0) {
            mReporter.warn(
                fmt::format("{}: {} voxels are not finite numbers and are left out", path, frame.made.unusableVoxels));
        }
        if (frame.made.histograms) {
            if (!mHistograms) mHistograms.emplace(frame.scene->look);
            mHistograms->add(*frame.made.histograms);
        }
        if (frame.wasDamaged) {
            mReporter.warn(fmt::format("{}: was there, but cannot be read as an image; it was made again",
                                       mOutput->path(frame.file.frame).string()));
        }
        if (mFilm) mFilm->add(frame.film);
        mSkipped += frame.skipped ? 1 : 0;
        mRendered += frame.skipped ? 0 : 1;
        mEmptyImages += frame.made.nothingSeen.empty() ? 0 : 1;
        mNothingSeen = frame.made.nothingSeen;
        tellPicture(frame);
        mReporter.progress(++mDone, mTotal);
    }

    /// A frame that cannot be read ends the run, or is left out.
    void leaveOut(const RenderedFrame& frame)
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

    void describe(const Scene& scene, std::int64_t frame)
    {
        mDescribed = true;
        if (mPlan.input.pattern == "-") tellTransfer();
        const Look& look = scene.look;
        const Camera camera = scene.cameras.at(frame);
        mReporter.detail(fmt::format("frame {}: {} from {} to {}, up {}", frame, nameOf(camera.projection()),
                                     vectorText(camera.eye()), vectorText(camera.target()), vectorText(camera.up())));
        const TransferFunction& transfer = look.transfer;
        mReporter.detail(fmt::format("{} {} to {} ({}), opacity by {} {} to {} ({}): {}, texture {} to {}, "
                                     "exposure {}",
                                     mPlan.picture.colorBy, transfer.range()[0], transfer.range()[1],
                                     nameOf(transfer.colorAxis().scale), scene.opacityBy, transfer.opacityRange()[0],
                                     transfer.opacityRange()[1], nameOf(transfer.opacityAxis().scale),
                                     opacityText(transfer.opacity()), look.texture.low, look.texture.high,
                                     look.exposure));
        const std::string which = mExchange.isAlone()
                                      ? fmt::format("{} frames at once", framesInFlight(scene.frameBytes))
                                      : fmt::format("each frame by {} ranks", mExchange.size());
        mReporter.detail(fmt::format("{}, about {:.0f} MB each", which, scene.frameBytes / 1e6));
    }

    const RenderPlan& mPlan;
    Reporter& mReporter;
    Exchange& mExchange;
    FrameRenderer mRenderer;
    std::size_t mTotal = 0, mTaken = 0, mDone = 0;
    FrameSource mSource;
    std::optional<FramePattern> mOutput;
    std::optional<FilmWriter> mFilm;
    std::optional<Scene> mScene;
    std::shared_ptr<const LoadedTexture> mOnlyFrame; // of the sequence, if it was read to make the scene
    std::optional<TextureHistograms> mHistograms;
    std::atomic<bool> mStopped = false; // take no further frame
    std::exception_ptr mError;
    std::size_t mSkipped = 0, mLeftOut = 0, mRendered = 0, mEmptyImages = 0;
    std::string mNothingSeen; // why the last image shows nothing
    bool mDescribed = false, mSaidNoColor = false;
};

} // namespace

void renderSequence(const RenderParams& params, std::istream& lines, Reporter& reporter)
{
    OneProcess alone;
    renderSequence(resolve(params), lines, reporter, alone);
}

void renderSequence(const RenderPlan& plan, std::istream& lines, Reporter& reporter, Exchange& exchange)
{
    exchange.together([&] {
        if (!plan.outputs.images.empty() || !plan.outputs.film.empty()) {
            const glm::ivec2 size = plan.picture.scaledSize();
            checkMemory(plan.picture.imageBytes(), fmt::format("an image of {}x{} pixels", size.x, size.y),
                        "make it smaller with `size` or `scale`");
        }
        SequenceRenderer(plan, lines, reporter, exchange).run();
    });
}

} // namespace vdblic
