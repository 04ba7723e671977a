#include "view/pictures.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/reporter.h"
#include "vdblic/image/image_file.h"
#include "vdblic/render/render_plan.h"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <utility>

namespace vdblic::view {
namespace {

constexpr int kMostSide = 8192; // pixels
constexpr std::size_t kMostClients = 6;

/// A place that is given back.
class Place {
  public:
    explicit Place(std::counting_semaphore<>& places) : mPlaces(places) { mPlaces.acquire(); }
    ~Place() { mPlaces.release(); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

  private:
    std::counting_semaphore<>& mPlaces;
};

/// A text that differs for pictures that differ in more than the number of their samples.
std::string keyOf(const PictureRequest& request, std::uint64_t version)
{
    nlohmann::json state = request.state;
    state.erase("samples");
    return fmt::format("{}|{}|{}", version, request.frame, state.dump());
}

} // namespace

std::shared_ptr<Pictures::Client> Pictures::clientOf(const PictureRequest& request, std::stop_token& stop)
{
    const std::lock_guard lock(mMutex);
    auto found = std::find_if(mClients.begin(), mClients.end(),
                              [&](const auto& client) { return client->name == request.client; });
    if (found == mClients.end()) {
        mClients.push_front(std::make_shared<Client>());
        mClients.front()->name = request.client;
        if (mClients.size() > kMostClients) mClients.pop_back();
    } else {
        mClients.splice(mClients.begin(), mClients, found);
    }
    Client& client = *mClients.front();
    const std::int64_t turn = request.turn.value_or(client.turn);
    if (turn < client.turn) throw Stopped{};
    client.turn = turn;
    client.newest.request_stop();
    client.newest = {};
    stop = client.newest.get_token();
    return mClients.front();
}

ShownPicture Pictures::picture(const PictureRequest& request, const std::function<bool()>& isGone)
{
    std::stop_token stop;
    const std::shared_ptr<Client> client = clientOf(request, stop);
    const std::lock_guard casting(client->casting);
    const auto checkStop = [&] {
        if (stop.stop_requested() || isGone()) throw Stopped{};
    };
    checkStop();
    const Place place(mPlaces);
    checkStop();
    const std::string key = keyOf(request, mViewer.version());
    const PicturePlan plan = planFor(request);
    if (!client->last || client->last->key != key || client->last->picture.samples() > plan.samples ||
        (request.settle && !client->last->view.settled)) {
        client->last.reset();
        client->last = std::make_unique<Cast>(key, mViewer.view(request.state, request.frame, request.settle));
    }
    ShownPicture result = shown(*client->last, plan, stop, [&](int) { checkStop(); });
    if (!result.settled) mViewer.settleLater(client->last->view);
    return result;
}

ShownPicture Pictures::whole(const PictureRequest& request, const std::function<void(int)>& progress,
                             const std::stop_token& stop)
{
    const PicturePlan plan = planFor(request);
    Cast cast({}, mViewer.view(request.state, request.frame, request.settle));
    ShownPicture result = shown(cast, plan, stop, progress);
    progress(plan.samples);
    return result;
}

void Pictures::end(const PictureRequest& request)
{
    try {
        std::stop_token stop;
        (void)clientOf(request, stop);
    } catch (const Stopped&) { // a newer one came
    }
}

std::string Pictures::thumbnail(const PictureRequest& request)
{
    constexpr int kMostThumbnailSide = 160, kQuality = 85;
    constexpr std::size_t kMostThumbnails = 200;
    PictureRequest asked = request;
    asked.state["samples"] = 1;
    const glm::ivec2 size = planFor(asked).size;
    if (std::max(size.x, size.y) > kMostThumbnailSide)
        throw ParameterError(fmt::format("a thumbnail may have {} pixels a side", kMostThumbnailSide));
    const std::lock_guard lock(mThumbnailMutex);
    const std::string key = keyOf(asked, mViewer.version());
    const auto found = std::ranges::find(mThumbnails, key, &std::pair<std::string, std::string>::first);
    if (found != mThumbnails.end()) return found->second;
    const ShownPicture picture = whole(asked, [](int) {}, {});
    mThumbnails.emplace_front(
        key, encodeJpeg(displayBytes(picture.image, picture.background), picture.image.size, kQuality));
    if (mThumbnails.size() > kMostThumbnails) mThumbnails.pop_back();
    return mThumbnails.front().second;
}

PicturePlan Pictures::planFor(const PictureRequest& request) const
{
    PicturePlan plan = planOf(mViewer.start(), request.state);
    const glm::ivec2 size = plan.size;
    if (std::max(size.x, size.y) > kMostSide)
        throw ParameterError(fmt::format("a picture may have {} pixels a side", kMostSide));
    checkMemory(plan.imageBytes(), fmt::format("an image of {}x{} pixels", size.x, size.y), "make it smaller");
    return plan;
}

ShownPicture Pictures::shown(Cast& cast, const PicturePlan& plan, const std::stop_token& stop,
                             const std::function<void(int)>& beforeSample)
{
    Picture& picture = cast.picture;
    const auto begin = std::chrono::steady_clock::now();
    while (picture.samples() < plan.samples) {
        beforeSample(picture.samples());
        picture.addSample(stop);
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    ShownPicture result{.image = picture.image(),
                        .header = picture.header(),
                        .background = plan.background,
                        .samples = plan.samples,
                        .settled = cast.view.settled};
    result.castSeconds = seconds.count();
    result.nothingSeen = picture.whyNothingIsSeen(result.image);
    return result;
}

std::string encodeJpeg(std::string_view pixels, const glm::ivec2& size, int quality)
{
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitCompress(), tjDestroy);
    unsigned char* bytes = nullptr;
    unsigned long length = 0;
    const int failed = tjCompress2(jpeg.get(), reinterpret_cast<const unsigned char*>(pixels.data()), size.x, 0, size.y,
                                   TJPF_RGB, &bytes, &length, quality < 90 ? TJSAMP_420 : TJSAMP_444, quality, 0);
    const std::unique_ptr<unsigned char, void (*)(unsigned char*)> freed(bytes, tjFree);
    if (failed != 0) throw std::runtime_error(fmt::format("JPEG: {}", tjGetErrorStr2(jpeg.get())));
    return {reinterpret_cast<const char*>(bytes), length};
}

} // namespace vdblic::view
