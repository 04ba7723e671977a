#include "vdblic/render/render_sequence.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/reporter.h"
#include "vdblic/image/film_writer.h"
#include "vdblic/image/image_file.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/input_files.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/render/annotation_font.h"
#include "vdblic/render/frame_feed.h"
#include "vdblic/render/frame_renderer.h"
#include "vdblic/render/frames_in_flight.h"
#include "vdblic/render/loaded_texture.h"
#include "vdblic/render/moment.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/run_report.h"

#include <fmt/format.h>
#include <glm/vec2.hpp>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <istream>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

InputFiles inputsOf(const RenderPlan& plan, const std::vector<Moment>& moments)
{
    InputFiles inputs;
    inputs.add(plan.picture.cameraFile);
    inputs.add(plan.picture.transferFile);
    for (const std::string& reference : {plan.picture.region, plan.picture.solid}) {
        if (reference.empty()) continue;
        const std::string path = parseGridReference(reference).path.string();
        inputs.add(path);
        for (const Moment& moment : moments)
            inputs.add(FramePattern(path).path(moment.file.frame));
    }
    for (const Moment& moment : moments) {
        inputs.add(moment.file.path);
        if (moment.next) inputs.add(moment.next->path);
        if (!plan.picture.lines.empty()) inputs.add(linesFile(plan.picture, moment.file.frame));
    }
    return inputs;
}

void checkFurtherOutput(const std::string& report, const RenderPlan& plan, const InputFiles& inputs)
{
    if (report.empty()) return;
    inputs.check(report);
    if (!plan.outputs.images.empty()) checkNoFrame(report, FramePattern(plan.outputs.images));
    checkReport(report);
}

/// Check, before any work, that the outputs of a run can be written, differ from each other and replace no input.
/// @param moments of the run; empty if its files come on standard input
/// @throws ParameterError, OutputError
void checkRenderOutputs(const RenderPlan& plan, const std::vector<Moment>& moments)
{
    const InputFiles inputs = inputsOf(plan, moments);
    const std::string* const further[] = {&plan.outputs.histogram, &plan.outputs.transferFunction, &plan.outputs.film};
    for (std::size_t i = 0; i < std::size(further); ++i) {
        checkFurtherOutput(*further[i], plan, inputs);
        for (std::size_t j = 0; j < i; ++j) {
            if (!further[i]->empty() && !further[j]->empty()) checkDistinct(*further[i], *further[j]);
        }
    }
    if (!plan.outputs.film.empty()) checkOutput(plan.outputs.film);
    if (plan.outputs.images.empty() || moments.empty()) return;
    std::vector<std::int64_t> numbers;
    numbers.reserve(moments.size());
    for (const Moment& moment : moments) {
        numbers.push_back(moment.number);
        inputs.check(FramePattern(plan.outputs.images).path(moment.number));
    }
    checkOutputs(FramePattern(plan.outputs.images), numbers);
}

void warnOfTitle(const std::string& title, Reporter& reporter)
{
    const std::string missing = title.empty() ? "" : annotationFont(title).missing;
    if (missing.empty()) return;
    reporter.warn(fmt::format("title '{}': no installed font has '{}', which is drawn as boxes; install one, such as "
                              "the package fonts-noto-cjk for Chinese, Japanese and Korean",
                              title, missing));
}

/// Renders frames and writes their images.
class ImageWriter {
  public:
    ImageWriter(const RenderPlan& plan, Reporter& reporter, Exchange& exchange)
        : mPlan(plan), mExchange(exchange), mRenderer(plan, reporter, exchange)
    {
    }

    /// Thread-safe for a process alone; else collective. An error waits for the frame's turn: the frames before it are
    /// still reported.
    [[nodiscard]] RenderedFrame write(const FrameTask& task) const
    {
        RenderedFrame result{.moment = task.moment, .view = task.view};
        try {
            mExchange.together([&] {
                if (task.error) std::rethrow_exception(task.error);
                const bool isThere = mPlan.outputs.skipExisting && hasImages() && mExchange.isFirst() &&
                                     isFinished(imageOf(task.moment));
                const bool isWhole = isThere && isWholeImage(imageOf(task.moment));
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

  private:
    [[nodiscard]] bool hasImages() const { return !mPlan.outputs.images.empty(); }
    [[nodiscard]] std::filesystem::path imageOf(const Moment& moment) const
    {
        return FramePattern(mPlan.outputs.images).path(moment.number);
    }

    void render(const FrameTask& task, RenderedFrame& result) const
    {
        const Background& background = mPlan.picture.background;
        const FrameImage made = mRenderer.render(task.loaded, result);
        if (!mPlan.outputs.film.empty()) result.film = displayBytes(made.image, background);
        if (hasImages() && mExchange.isFirst())
            writeImage(imageOf(task.moment), made.image, made.header, background, mPlan.outputs.exr);
    }

    const RenderPlan& mPlan;
    Exchange& mExchange;
    FrameRenderer mRenderer;
};

/// Render frames at the same time, and report them one by one in order.
/// @param frames     in memory at a time
/// @param untilView  end once a frame has an active voxel
void runPipeline(std::size_t frames, bool untilView, FrameFeed& feed, const ImageWriter& writer, RunReport& report,
                 const std::function<void(const RenderedFrame&)>& finish)
{
    // An exception that left the pipeline would cancel OpenVDB's work on other frames, and OpenVDB crashes on
    // half-built trees. So it is thrown once the pipeline is empty.
    std::exception_ptr first;
    std::atomic<bool> hasFailed = false;
    const auto next = [&](tbb::flow_control& flow) {
        std::optional<FrameTask> task;
        if (!hasFailed && !(untilView && feed.view())) task = feed.next();
        if (!task) flow.stop();
        return task.value_or(FrameTask{});
    };
    const auto write = [&](const FrameTask& task) { return writer.write(task); };
    const auto tell = [&](const RenderedFrame& frame) {
        try {
            first ? report.tellPicture(frame) : finish(frame);
        } catch (...) {
            first = std::current_exception();
            hasFailed = true;
        }
    };
    using tbb::filter_mode;
    tbb::parallel_pipeline(frames, tbb::make_filter<void, FrameTask>(filter_mode::serial_in_order, next) &
                                       tbb::make_filter<FrameTask, RenderedFrame>(filter_mode::parallel, write) &
                                       tbb::make_filter<RenderedFrame, void>(filter_mode::serial_in_order, tell));
    if (first) std::rethrow_exception(first);
}

void renderFrames(const RenderPlan& plan, std::istream& lines, Reporter& reporter, Exchange& exchange)
{
    const RenderOutputs& outputs = plan.outputs;
    const bool isPiped = plan.input.pattern == "-";
    checkRenderOutputs(plan, isPiped ? std::vector<Moment>{} : momentsOf(plan));
    std::optional<FilmWriter> film;
    if (!outputs.film.empty()) film.emplace(outputs.film, plan.picture.size, outputs.framesPerSecond);
    FrameFeed feed(plan, lines, reporter, exchange);
    RunReport report(plan, reporter, feed.total());
    if (feed.view()) report.tellView(*feed.view());
    if (!isPiped && outputs.images.empty() && !film && outputs.histogram.empty()) {
        if (!feed.view()) throw InputError(fmt::format("{}: no frame has an active voxel", plan.input.pattern));
        return;
    }
    warnOfTitle(plan.picture.annotations.title, reporter);
    reporter.progress(0, feed.total());
    const ImageWriter writer(plan, reporter, exchange);
    bool isAny = false;
    const auto finish = [&](const RenderedFrame& frame) {
        if (film && !frame.error) film->add(frame.film);
        report.add(frame, exchange);
        isAny = true;
    };
    if (exchange.isAlone()) {
        // How many frames fit in memory is known once one has been read.
        if (!feed.view()) runPipeline(1, /*untilView=*/true, feed, writer, report, finish);
        const double bytes = feed.view() ? feed.view()->frameBytes : 1;
        runPipeline(framesInFlight(bytes), /*untilView=*/false, feed, writer, report, finish);
    } else {
        while (const std::optional<FrameTask> task = feed.next())
            finish(writer.write(*task));
    }
    reporter.checkStop(); // a request to stop ends standard input
    if (!isAny) throw InputError("no frame to render: standard input named none");
    if (film) {
        film->finish();
        reporter.finished(outputs.film);
    }
    report.finish(feed.view());
}

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
            const glm::ivec2 size = plan.picture.size;
            checkMemory(plan.picture.imageBytes(), fmt::format("an image of {}x{} pixels", size.x, size.y),
                        "make it smaller with `size`");
        }
        renderFrames(plan, lines, reporter, exchange);
    });
}

} // namespace vdblic
