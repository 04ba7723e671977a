#pragma once

#include "view/pictures.h"
#include "view/viewer.h"

#include <nlohmann/json.hpp>

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace vdblic::view {

/// Writes what was found into the folder in which the viewer was started, under names that are still free:
/// view-001.transfer.json, view-001.camera.json, view-001.png, view-001.mp4.
class Keeper {
  public:
    Keeper(Viewer& viewer, Pictures& pictures) : mViewer(viewer), mPictures(pictures) {}
    ~Keeper();
    Keeper(const Keeper&) = delete;
    Keeper& operator=(const Keeper&) = delete;

    /// Write transfer function and camera. @return their names as `files`, and `command`, which renders with them
    /// @throws OutputError, and as Viewer::view()
    [[nodiscard]] nlohmann::json keepFiles(const nlohmann::json& state, std::int64_t frame);
    /// Write the picture. @param format png or exr  @throws ParameterError, OutputError, and as Pictures::picture()
    [[nodiscard]] nlohmann::json keepPicture(const PictureRequest& request, const std::string& format,
                                             const std::function<bool()>& isGone);
    /// Begin a film of all frames. @throws ParameterError if one is being made, or on a bad rate
    [[nodiscard]] nlohmann::json beginFilm(const nlohmann::json& state, double framesPerSecond);
    void stopFilm() { mStopFilm = true; }
    /// The film's `file`, frames `done` of `total`, and `error` once it has failed; null before the first film.
    [[nodiscard]] nlohmann::json film();

  private:
    class FilmReporter;

    /// A free name for each of these endings, with one number.
    [[nodiscard]] std::string freeName() const;

    Viewer& mViewer;
    Pictures& mPictures;
    std::mutex mMutex; // of names and the film
    nlohmann::json mFilm;
    std::atomic<bool> mStopFilm = false;
    std::thread mFilmThread;
};

} // namespace vdblic::view
