#include "vdblic/render/render_sequence.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/render/frames_in_flight.h"
#include "vdblic/render/histogram.h"
#include "vdblic/render/image_attributes.h"
#include "vdblic/render/scene.h"
#include "vdblic/render/supersampling.h"

#include <tbb/parallel_pipeline.h>

#include <atomic>
#include <cmath>
#include <exception>

namespace vdblic {
namespace {

constexpr int kMostPixels = 32768; // a side
constexpr double kMostStretch = 1e6;

/// A frame's turn, or an error in place of it.
struct FrameTask {
    FrameFile file;
    std::shared_ptr<const LoadedTexture> loaded; ///< if it was needed before its turn
    const Scene* scene = nullptr;                ///< null as long as no frame had an active voxel
    std::exception_ptr error;
};

/// What became of a frame: its image is on disk, or there was an error.
struct RenderedFrame {
    FrameFile file;
    const Scene* scene = nullptr;
    bool hasMagnitude = true;
    std::size_t unusableVoxels = 0;
    std::optional<TextureHistograms> histograms;
    std::exception_ptr error;
};

/// The run over a sequence: frames are taken one by one, rendered side by side, and reported one by one in their order.
class SequenceRenderer {
  public:
    SequenceRenderer(const RenderParams& params, std::istream& lines, Reporter& reporter)
        : mParams(params), mRays(params.rays), mReporter(reporter), mSource(openSequence(params.input, lines, mTotal))
    {
        mRays.clip = params.rays.clip.stretched(params.stretch);
        if (params.output.empty()) return;
        mOutput.emplace(params.output);
        if (mTotal > 0) checkOutputPattern(*mOutput, mTotal);
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
        // How many fit side by side is known once one has been seen.
        if (!mScene) runPipeline(1, /*untilScene=*/true);
        runPipeline(framesInFlight(mScene ? mScene->frameBytes : 1), /*untilScene=*/false);
        mReporter.checkStop(); // it may have ended standard input
        if (mDone == 0) throw InputError("no frame to render: standard input named none");
        if (mParams.histogram.empty()) return;
        if (!mHistograms) throw InputError("no active voxel was met; there is nothing to make histograms of");
        writeHistograms(mParams.histogram, *mHistograms, mScene->look);
        mReporter.finished(mParams.histogram);
    }

  private:
    /// @param untilScene end once a frame has shown something
    void runPipeline(std::size_t frames, bool untilScene)
    {
        const auto next = [&](tbb::flow_control& flow) {
            FrameTask task;
            if ((untilScene && mScene) || !take(task)) flow.stop();
            return task;
        };
        const auto work = [&](const FrameTask& task) { return finish(task); };
        // An exception that left the pipeline would cancel the half-done work of other frames in OpenVDB, which then
        // crashes on its half-built trees; so it waits until they are through.
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

    /// The next frame's turn; false at the end and after an error.
    bool take(FrameTask& task)
    {
        if (mStopped) return false;
        try {
            mReporter.checkStop();
            const std::optional<FrameFile> file = mSource();
            if (!file) return false;
            if (mOutput) checkNotInput(mOutput->path(file->frame), file->path);
            if (mTaken++ == 1 && mOutput) checkOutputPattern(*mOutput, 2); // paths of which there is a second one
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

    /// Render a frame and write its image. An error is kept for its turn, so that those before it are still finished.
    RenderedFrame finish(const FrameTask& task) const
    {
        RenderedFrame result{task.file, task.scene};
        result.error = task.error;
        const bool skipped = mOutput && mParams.skipExisting && isFinished(mOutput->path(task.file.frame));
        if (result.error || skipped) return result;
        try {
            // While it waits for its own tiles, a thread must not get caught in waiting for the next path.
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
        result.hasMagnitude = frame->hasMagnitude;
        result.unusableVoxels = frame->volume.unusableVoxels();
        if (!mParams.histogram.empty() && task.scene) {
            result.histograms.emplace(task.scene->look);
            result.histograms->add(*frame->texture, *frame->magnitude);
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
        if (!frame.hasMagnitude && !mSaidNoMagnitude) {
            mReporter.say(
                fmt::format("{}: no float grid 'magnitude'; the texture chooses colour and opacity instead", path));
            mSaidNoMagnitude = true;
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
        const auto text = [](const glm::dvec3& v) { return fmt::format("{} {} {}", v.x, v.y, v.z); };
        mReporter.detail(fmt::format("frame {}: {} from {} to {}, up {}", frame, toString(camera.projection()),
                                     text(camera.eye()), text(camera.target()), text(camera.up())));
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
    std::shared_ptr<const LoadedTexture> mOnlyFrame; // if it was read to make the scene
    std::optional<TextureHistograms> mHistograms;
    std::atomic<bool> mStopped = false; // no further frame is to be taken
    std::exception_ptr mError;
    bool mDescribed = false, mSaidNoMagnitude = false;
};

} // namespace

void RenderParams::validate() const
{
    if (output.empty() && histogram.empty()) throw ParameterError("there is nothing to make: give an output");
    if (!output.empty()) {
        const bool exrOutput = imageFormat(output) == ImageFormat::kExr;
        if (!exr.layers.empty() && !exrOutput) {
            throw ParameterError(fmt::format("output '{}': only .exr holds further channels", output));
        }
    }
    if (!histogram.empty()) checkHistogramPath(histogram);
    camera.validate();
    motion.validate();
    look.validate();
    rays.validate();
    background.validate();
    exr.validate();
    if (motion.orbit != 0 && !motion.orbitFrames && (input.pattern == "-" || !FramePattern(input.pattern).hasField())) {
        throw ParameterError("how many frames the orbit takes must be given, since the input does not tell");
    }
    for (const double factor : {stretch.x, stretch.y, stretch.z}) {
        if (!(factor >= 1 / kMostStretch && factor <= kMostStretch)) {
            throw ParameterError(
                fmt::format("stretch {} must be between {} and {}", factor, 1 / kMostStretch, kMostStretch));
        }
    }
    if (!(scale > 0 && scale <= kMostPixels)) {
        throw ParameterError(fmt::format("scale {} must be above 0 and at most {}", scale, kMostPixels));
    }
    for (const glm::ivec2& sides : {size, scaledSize()}) {
        if (std::min(sides.x, sides.y) >= 1 && std::max(sides.x, sides.y) <= kMostPixels) continue;
        throw ParameterError(
            fmt::format("image size {}x{} must be 1 to {} pixels a side", sides.x, sides.y, kMostPixels));
    }
    if (samples < 1 || samples > kMostSamples) {
        throw ParameterError(fmt::format("{} samples to a pixel must be 1 to {}", samples, kMostSamples));
    }
}

glm::ivec2 RenderParams::scaledSize() const
{
    const auto scaled = [&](int side) { return int(std::clamp(std::round(side * scale), 1.0, 1e9)); };
    return {scaled(size.x), scaled(size.y)};
}

double RenderParams::imageBytes() const
{
    // The sum over the samples, one of them, the file's pixels, and the file.
    const double perPixel = sizeof(glm::vec4) * 4 + (rays.layers ? 2 * sizeof(PixelLayers) : 0);
    return double(scaledSize().x) * scaledSize().y * perPixel;
}

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
