#include "vdblic/render/render_sequence.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/render/frames_in_flight.h"
#include "vdblic/render/histogram.h"
#include "vdblic/render/image_attributes.h"
#include "vdblic/render/scene.h"
#include "vdblic/render/supersampling.h"
#include "vdblic/render/vector_text.h"

#include <fmt/format.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <istream>
#include <memory>
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
    bool hasDriver = true;
    std::size_t unusableVoxels = 0;
    std::optional<TextureHistograms> histograms;
    std::exception_ptr error;
};

/// The run over a sequence: frames are taken one by one, rendered in parallel, and reported one by one in order.
class SequenceRenderer {
  public:
    SequenceRenderer(const RenderParams& params, std::istream& lines, Reporter& reporter)
        : mParams(params), mRays(params.rays), mReporter(reporter), mSource(openSequence(params.input, lines, mTotal))
    {
        mRays.clip = params.rays.clip.stretched(params.stretch);
        if (!params.histogram.empty()) checkReport(params.histogram);
        if (params.output.empty()) return;
        mOutput.emplace(params.output);
        if (mTotal > 0) checkOutputs(*mOutput, selectedFrames(params.input));
        if (!mParams.histogram.empty()) checkNoFrame(mParams.histogram, *mOutput);
    }

    void run()
    {
        if (mParams.input.pattern != "-") {
            if (std::optional<SequenceScene> found = sceneOfSequence(mParams)) {
                mScene = std::move(found->scene);
                mOnlyFrame = std::move(found->onlyFrame);
            }
        }
        mReporter.progress(0, mTotal);
        // How many frames fit in memory is known once one has been read.
        if (!mScene) runPipeline(1, /*untilScene=*/true);
        runPipeline(framesInFlight(mScene ? mScene->frameBytes : 1), /*untilScene=*/false);
        mReporter.checkStop(); // a request to stop ends standard input
        if (mDone == 0) throw InputError("no frame to render: standard input named none");
        if (mParams.histogram.empty()) return;
        if (!mHistograms) throw InputError("no active voxel was met; there is nothing to make histograms of");
        if (writeHistograms(mParams.histogram, *mHistograms, mScene->look)) mReporter.finished(mParams.histogram);
    }

  private:
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
            if (mError) return;
            try {
                report(frame);
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
            if (mOutput && mParams.input.pattern == "-") checkOutput(mOutput->path(file->frame));
            if (mTaken++ == 1 && mOutput) checkOutputPattern(*mOutput, 2); // standard input named a second path
            task.file = *file;
            if (mOnlyFrame && mOnlyFrame->file.path == file->path) task.loaded = std::exchange(mOnlyFrame, nullptr);
            if (!mScene) {
                task.loaded = std::make_shared<const LoadedTexture>(loadFrame(mParams, *file));
                if (!task.loaded->volume.empty())
                    mScene = chooseScene(mParams, {task.loaded.get(), 1}, task.loaded->volume.corners(), {});
            }
            if (mScene) task.scene = &*mScene;
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
        result.error = task.error;
        const bool skipped = mOutput && mParams.skipExisting && isFinished(mOutput->path(task.file.frame));
        if (result.error || skipped) return result;
        try {
            // While a thread waits for this frame's tiles, it must not start to wait for the next path.
            tbb::this_task_arena::isolate([&] { render(task, result); });
        } catch (...) {
            result.error = std::current_exception();
        }
        return result;
    }

    void render(const FrameTask& task, RenderedFrame& result) const
    {
        const auto frame =
            task.loaded ? task.loaded : std::make_shared<const LoadedTexture>(loadFrame(mParams, task.file));
        result.hasDriver = frame->hasDriver;
        result.unusableVoxels = frame->volume.unusableVoxels();
        if (!mParams.histogram.empty() && task.scene) {
            result.histograms.emplace(task.scene->look);
            result.histograms->add(*frame->texture, *frame->driver);
        }
        if (!mOutput) return;
        const glm::ivec2 size = mParams.scaledSize();
        Image image{size, std::vector<glm::vec4>(std::size_t(size.x) * size.y, glm::vec4(0))};
        ImageHeader header;
        if (task.scene) {
            const Camera camera = task.scene->cameras.at(task.file.frame);
            image = castSamples(frame->volume, task.scene->look, camera, mRays, mParams.samples);
            header = imageHeader(mParams, task.scene->look, camera, task.file);
        } else if (mParams.rays.layers) {
            image.layers.resize(image.pixels.size());
        }
        writeImage(mOutput->path(task.file.frame), image, header, mParams.background, mParams.exr);
    }

    void report(const RenderedFrame& frame)
    {
        if (frame.error) std::rethrow_exception(frame.error);
        const std::string path = frame.file.path.string();
        if (frame.scene && !mDescribed) describe(*frame.scene, frame.file.frame);
        if (!frame.hasDriver && !mSaidNoDriver) {
            mReporter.say(
                fmt::format("{}: no float grid 'magnitude'; the texture chooses colour and opacity instead", path));
            mSaidNoDriver = true;
        }
        if (frame.unusableVoxels > 0) {
            mReporter.warn(
                fmt::format("{}: {} voxels are not finite numbers and are left out", path, frame.unusableVoxels));
        }
        if (frame.histograms) {
            if (!mHistograms) mHistograms.emplace(frame.scene->look);
            mHistograms->add(*frame.histograms);
        }
        if (mOutput) mReporter.finished(mOutput->path(frame.file.frame));
        mReporter.progress(++mDone, mTotal);
    }

    void describe(const Scene& scene, std::int64_t frame)
    {
        mDescribed = true;
        const Look& look = scene.look;
        const Camera camera = scene.cameras.at(frame);
        mReporter.detail(fmt::format("frame {}: {} from {} to {}, up {}", frame, toString(camera.projection()),
                                     vectorText(camera.eye()), vectorText(camera.target()), vectorText(camera.up())));
        mReporter.detail(fmt::format("magnitude {} to {}, opacity {}, texture {} to {}", look.transfer.range()[0],
                                     look.transfer.range()[1], opacityText(look.transfer.opacity()), look.texture.low,
                                     look.texture.high));
        mReporter.detail(fmt::format("{} frames at once, about {:.0f} MB each", framesInFlight(scene.frameBytes),
                                     scene.frameBytes / 1e6));
    }

    const RenderParams& mParams;
    RayCastParams mRays;
    Reporter& mReporter;
    std::size_t mTotal = 0, mTaken = 0, mDone = 0;
    FrameSource mSource;
    std::optional<FramePattern> mOutput;
    std::optional<Scene> mScene;
    std::shared_ptr<const LoadedTexture> mOnlyFrame; // of the sequence, if it was read to make the scene
    std::optional<TextureHistograms> mHistograms;
    std::atomic<bool> mStopped = false; // take no further frame
    std::exception_ptr mError;
    bool mDescribed = false, mSaidNoDriver = false;
};

} // namespace

void renderSequence(const RenderParams& params, std::istream& lines, Reporter& reporter)
{
    params.validate();
    if (!params.output.empty()) {
        const glm::ivec2 size = params.scaledSize();
        checkMemory(params.imageBytes(), fmt::format("an image of {}x{} pixels", size.x, size.y),
                    "make it smaller with `size` or `scale`");
    }
    SequenceRenderer(params, lines, reporter).run();
}

} // namespace vdblic
