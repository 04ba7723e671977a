#pragma once

#include "view/keeper.h"
#include "view/pictures.h"
#include "view/viewer.h"
#include "view/web_server.h"

#include <nlohmann/json.hpp>

namespace vdblic::view {

/// What the page asks the server (docs/view.md): JSON in, JSON or a picture out.
class Interface {
  public:
    explicit Interface(Viewer& viewer) : mViewer(viewer), mPictures(viewer), mKeeper(viewer, mPictures) {}

    /// Any number of threads may ask. Errors become answers.
    [[nodiscard]] WebAnswer answer(const WebRequest& request);

  private:
    [[nodiscard]] WebAnswer answerAsked(const WebRequest& request);
    [[nodiscard]] nlohmann::json sequence();
    [[nodiscard]] nlohmann::json status();
    [[nodiscard]] nlohmann::json scene(const nlohmann::json& state, std::int64_t frame);
    [[nodiscard]] nlohmann::json keep(const nlohmann::json& asked);
    [[nodiscard]] WebAnswer picture(const nlohmann::json& asked, const WebRequest& request);

    Viewer& mViewer;
    Pictures mPictures;
    Keeper mKeeper;
};

} // namespace vdblic::view
