#pragma once

#include "vdblic/image/image.h"
#include "vdblic/render/picture.h"
#include "view/viewer.h"

#include <glm/vec2.hpp>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <semaphore>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

namespace vdblic::view {

/// A picture that a client asks for.
struct PictureRequest {
    std::string client;               ///< a name of its own choice
    std::optional<std::int64_t> turn; ///< the client's number of the request; without one it is its newest
    nlohmann::json state;
    std::int64_t frame = 1;
    bool settle = false; ///< as Viewer::view()
};

/// A picture, with its header and its state.
struct ShownPicture {
    Image image;
    ImageHeader header;
    Background background;
    int samples = 1;
    bool settled = false;
    std::string nothingSeen; ///< why it is empty; empty if it is not
    double castSeconds = 0;  ///< that the rays of this request took: the part that follows the number of pixels
};

/// The pictures of all clients. Of each client the newest request counts: an older one ends,
/// whether it is being cast or arrives late. The
/// samples of a client's last picture are kept, so that a picture with more of them continues it.
class Pictures {
  public:
    explicit Pictures(Viewer& viewer) : mViewer(viewer) {}

    /// @param isGone whether the client has gone away
    /// @throws Stopped if a newer request came or the client has gone away; as Viewer::view()
    [[nodiscard]] ShownPicture picture(const PictureRequest& request, const std::function<bool()>& isGone);
    /// A picture that no newer request ends. @param progress called with the number of samples that are there
    /// @throws Stopped, and as Viewer::view()
    [[nodiscard]] ShownPicture whole(const PictureRequest& request, const std::function<void(int)>& progress,
                                     const std::stop_token& stop);
    /// End the client's pictures that are older than the request.
    void end(const PictureRequest& request);
    /// A JPEG of one ray a pixel, made once: of many that were made the newest are kept. One at a time.
    /// @throws ParameterError if it is not small; as Viewer::view()
    [[nodiscard]] std::string thumbnail(const PictureRequest& request);
    /// The plan of a picture. @throws ParameterError, InputError if it is too large
    [[nodiscard]] PicturePlan planFor(const PictureRequest& request) const;

  private:
    /// A picture with everything that it refers to.
    struct Cast {
        std::string key;
        FrameView view;
        Picture picture;

        Cast(std::string k, FrameView v)
            : key(std::move(k)), view(std::move(v)), picture(view.plan, view.view, view.shown)
        {
        }
    };
    struct Client {
        std::string name;
        std::stop_source newest; // of its newest request
        std::int64_t turn = 0;   // the request's
        std::mutex casting;
        std::unique_ptr<Cast> last;
    };

    /// The client, whose older request is asked to end.
    /// @throws Stopped if the request is the older one: requests on different connections may change places
    [[nodiscard]] std::shared_ptr<Client> clientOf(const PictureRequest& request, std::stop_token& stop);
    /// Cast the missing samples of a picture. @param beforeSample called with the number of samples that are there
    [[nodiscard]] static ShownPicture shown(Cast& cast, const PicturePlan& plan, const std::stop_token& stop,
                                            const std::function<void(int)>& beforeSample);

    Viewer& mViewer;
    std::mutex mMutex;
    std::list<std::shared_ptr<Client>> mClients; // the last one that asked first
    std::counting_semaphore<> mPlaces{4};        // for pictures that are cast at a time
    std::mutex mThumbnailMutex;
    std::list<std::pair<std::string, std::string>> mThumbnails; // by their keys, the newest first
};

/// The bytes of a JPEG file.
/// @param pixels  red, green and blue of each pixel, rows from the top
/// @param quality 1 to 100; colours are halved in resolution below 90
[[nodiscard]] std::string encodeJpeg(std::string_view pixels, const glm::ivec2& size, int quality);

} // namespace vdblic::view
