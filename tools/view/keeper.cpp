#include "view/keeper.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/reporter.h"
#include "vdblic/image/image_file.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/look/transfer_file.h"
#include "vdblic/render/render_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
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

/// Run work whose errors are told to nobody but the page.
template<typename Work>
std::string errorOf(const Work& work)
{
    try {
        work();
        return {};
    } catch (const Stopped&) {
        return "stopped";
    } catch (const std::exception& error) {
        return error.what();
    }
}

} // namespace

/// Tells the progress of a film to its keeper.
class Keeper::FilmReporter : public Reporter {
  public:
    explicit FilmReporter(Keeper& keeper) : mKeeper(keeper) {}
    void progress(std::size_t done, std::size_t total) override
    {
        const std::lock_guard lock(mKeeper.mMutex);
        mKeeper.mFilm["done"] = done;
        mKeeper.mFilm["total"] = total;
    }
    [[nodiscard]] bool stopRequested() const override { return mKeeper.mStopFilm; }

  private:
    Keeper& mKeeper;
};

Keeper::~Keeper()
{
    mStopFilm = true;
    if (mFilmThread.joinable()) mFilmThread.join();
}

std::string Keeper::freeName() const
{
    for (int number = 1;; ++number) {
        const std::string name = fmt::format("view-{:03}", number);
        const auto isTaken = [&](const char* ending) { return std::filesystem::exists(name + ending); };
        const char* const endings[] = {".transfer.json", ".camera.json", ".png", ".exr", ".mp4"};
        if (std::none_of(std::begin(endings), std::end(endings), isTaken) &&
            (mFilm.is_null() || mFilm["file"] != name + ".mp4"))
            return name;
    }
}

Json Keeper::keepFiles(const Json& state, std::int64_t frame)
{
    const View view = mViewer.view(state, frame, /*settle=*/true);
    const std::lock_guard lock(mMutex);
    const std::string name = freeName(), transfer = name + ".transfer.json", camera = name + ".camera.json";
    Json keys = state.value("keys", Json());
    if (keys.is_null()) keys = Json::array({keyOf(view.scene.cameras.at(frame), frame)});
    writeTransferFile(transfer, view.scene.look.transfer.params());
    writeTextFile(camera, Json{{"keys", keys}}.dump(2) + '\n');
    Json rest = state; // what the two files do not hold
    for (const char* held : {"colormap", "colors", "opacity", "range", "opacity-range", "color-scale", "opacity-scale",
                             "eye", "target", "up", "fov", "view-height", "orbit", "orbit-frames", "keys"})
        rest.erase(held);
    Start start = mViewer.start();
    start.fixed.erase("transfer");
    return {{"files", {transfer, camera}},
            {"command", commandOf(start, rest, {"--transfer", transfer, "--camera", camera, "-o", "image.%04d.png"})}};
}

Json Keeper::keepPicture(const PictureRequest& request, const std::string& format, const std::function<bool()>& isGone)
{
    if (format != "png" && format != "exr") throw ParameterError("a picture is kept as png or exr");
    const ShownPicture picture = mPictures.picture(request, isGone);
    const std::lock_guard lock(mMutex);
    const std::string name = freeName() + "." + format;
    writeImage(name, picture.image, picture.header, picture.background, picture.exr);
    return {{"files", {name}}};
}

Json Keeper::beginFilm(const Json& state, double framesPerSecond)
{
    RenderParams params = paramsOf(mViewer.start(), state);
    params.texture = mViewer.texture();
    params.framesPerSecond = framesPerSecond;
    const std::lock_guard lock(mMutex);
    if (!mFilm.is_null() && !mFilm["finished"].get<bool>())
        throw ParameterError("a film is being made; wait for its end or stop it");
    params.film = freeName() + ".mp4";
    params.validate();
    if (mFilmThread.joinable()) mFilmThread.join();
    mStopFilm = false;
    mFilm = {{"file", params.film}, {"done", 0}, {"total", 0}, {"finished", false}, {"error", ""}};
    mFilmThread = std::thread([this, params] {
        FilmReporter reporter(*this);
        std::istringstream noPaths;
        const std::string error = errorOf([&] { renderSequence(params, noPaths, reporter); });
        const std::lock_guard done(mMutex);
        mFilm["error"] = error;
        mFilm["finished"] = true;
    });
    return mFilm;
}

Json Keeper::film()
{
    const std::lock_guard lock(mMutex);
    return mFilm;
}

} // namespace vdblic::view
