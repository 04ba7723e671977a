#include "view/keeper.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/image/image_file.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/json_file.h"
#include "vdblic/look/transfer_file.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/render_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <new>
#include <sstream>
#include <utility>
#include <vector>

namespace vdblic::view {
namespace {

using Json = nlohmann::json;

Json list(const glm::dvec3& v)
{
    return {v.x, v.y, v.z};
}

/// A key frame that holds a whole camera.
Json keyOf(const Camera& camera, std::int64_t frame)
{
    Json key{
        {"frame", frame}, {"eye", list(camera.eye())}, {"target", list(camera.target())}, {"up", list(camera.up())}};
    if (camera.projection() == Projection::kPerspective) {
        key["fov"] = camera.fieldOfView();
    } else {
        key["height"] = 2 * camera.halfExtent().y;
    }
    return key;
}

/// Run work whose errors go to the page.
template<typename Work>
std::string errorOf(const Work& work)
{
    try {
        work();
        return {};
    } catch (const Stopped&) {
        return "stopped";
    } catch (const std::bad_alloc&) {
        return "this takes more memory than may be used";
    } catch (const std::exception& error) {
        return error.what();
    }
}

} // namespace

/// Tells the progress of a job to its keeper.
class Keeper::JobReporter : public Reporter {
  public:
    JobReporter(Keeper& keeper, Json& told, std::stop_token stop) : mKeeper(keeper), mTold(told), mStop(std::move(stop))
    {
    }
    void progress(std::size_t done, std::size_t total) override
    {
        const std::lock_guard lock(mKeeper.mMutex);
        mTold["done"] = done;
        mTold["total"] = total;
    }
    [[nodiscard]] bool stopRequested() const override { return mStop.stop_requested(); }

  private:
    Keeper& mKeeper;
    Json& mTold;
    std::stop_token mStop;
};

std::string Keeper::freeName() const
{
    for (int number = 1;; ++number) {
        std::string name = fmt::format("view-{:03}", number);
        const auto isTaken = [&](const char* ending) { // also by a link that leads nowhere yet, and would be followed
            return std::filesystem::exists(std::filesystem::symlink_status(name + ending));
        };
        const char* const endings[] = {".transfer.json", ".camera.json", ".png", ".exr", ".mp4"};
        const auto isWritten = [&](const Job& job) {
            return !job.isFinished() && job.told["file"].get_ref<const std::string&>().starts_with(name + '.');
        };
        if (std::none_of(std::begin(endings), std::end(endings), isTaken) &&
            std::none_of(mJobs.begin(), mJobs.end(), isWritten))
            return name;
    }
}

Json Keeper::keepFiles(const Json& state, std::int64_t frame)
{
    const FrameView view = mViewer.view(state, frame, /*settle=*/true);
    const std::lock_guard lock(mMutex);
    const std::string name = freeName(), transfer = name + ".transfer.json", camera = name + ".camera.json";
    Json keys = state.value("keys", Json());
    if (keys.is_null()) keys = Json::array({keyOf(view.view.cameras.at(double(frame)), frame)});
    writeTransferFile(transfer, view.view.look.transfer.params());
    writeTextFile(camera, jsonText(Json{{"keys", keys}}));
    Json rest = state; // options that the two files do not hold
    for (const char* held :
         {"colormap", "colors", "opacity", "range", "opacity-range", "color-scale", "opacity-scale", "view", "angles",
          "eye", "target", "up", "fov", "view-height", "orbit", "orbit-frames", "keys"})
        rest.erase(held);
    Start start = mViewer.start();
    start.fixed.erase("transfer");
    return {{"files", {transfer, camera}},
            {"command", commandOf(start, rest, {"--transfer", transfer, "--camera", camera, "-o", "image.%04d.png"})}};
}

Json Keeper::begin(const std::string& ending, std::size_t total,
                   const std::function<Work(const std::string& file)>& work)
{
    constexpr std::size_t kMostRunning = 3, kMostTold = 8;
    const std::lock_guard lock(mMutex);
    const auto running = [](const Job& job) { return !job.isFinished(); };
    const auto isFilm = [](const Job& job) { return job.told["file"].get_ref<const std::string&>().ends_with(".mp4"); };
    if (ending == ".mp4" &&
        std::any_of(mJobs.begin(), mJobs.end(), [&](const Job& job) { return running(job) && isFilm(job); }))
        throw ParameterError("a film is being made; wait for its end or stop it");
    if (std::count_if(mJobs.begin(), mJobs.end(), running) >= std::ptrdiff_t(kMostRunning))
        throw ParameterError(fmt::format("{} pictures are being made; wait for an end or stop one", kMostRunning));
    const std::string file = freeName() + ending;
    Work write = work(file);
    const auto oldest = std::find_if_not(mJobs.begin(), mJobs.end(), running);
    if (mJobs.size() >= kMostTold && oldest != mJobs.end()) mJobs.erase(oldest);
    Job& job = mJobs.emplace_back(
        Job{{{"job", mNext++}, {"file", file}, {"done", 0}, {"total", total}, {"finished", false}, {"error", ""}}, {}});
    job.thread = std::jthread([this, &told = job.told, write = std::move(write)](const std::stop_token& stop) {
        JobReporter reporter(*this, told, stop);
        const std::string error = errorOf([&] { write(reporter, stop); });
        const std::lock_guard done(mMutex);
        told["error"] = error;
        told["finished"] = true;
    });
    return job.told;
}

Json Keeper::beginPicture(const PictureRequest& request, const std::string& format)
{
    if (format != "png" && format != "exr") throw ParameterError("a picture is kept as png or exr");
    const auto samples = std::size_t(mPictures.planFor(request).samples);
    return begin("." + format, samples, [&](const std::string& file) -> Work {
        return [this, request, samples, file](Reporter& reporter, const std::stop_token& stop) {
            const auto progress = [&](int done) { reporter.progress(std::size_t(done), samples); };
            const ShownPicture picture = mPictures.whole(request, progress, stop);
            writeImage(file, picture.image, picture.header, picture.background);
        };
    });
}

Json Keeper::beginFilm(const Json& state, double framesPerSecond)
{
    RenderPlan plan{.input = mViewer.start().input, .picture = planOf(mViewer.start(), state), .outputs = {}};
    plan.outputs.framesPerSecond = framesPerSecond;
    return begin(".mp4", 0, [&](const std::string& file) -> Work {
        plan.outputs.film = file;
        plan.outputs.validate();
        return [plan](Reporter& reporter, const std::stop_token&) {
            std::istringstream noPaths;
            OneProcess alone;
            renderSequence(plan, noPaths, reporter, alone);
        };
    });
}

void Keeper::stop(std::int64_t job)
{
    const std::lock_guard lock(mMutex);
    const auto found = std::find_if(mJobs.begin(), mJobs.end(), [&](const Job& one) { return one.told["job"] == job; });
    if (found == mJobs.end()) throw ParameterError(fmt::format("there is no job {}", job));
    found->thread.request_stop();
}

Json Keeper::jobs()
{
    const std::lock_guard lock(mMutex);
    Json list = Json::array();
    for (const Job& job : mJobs)
        list.push_back(job.told);
    return list;
}

} // namespace vdblic::view
