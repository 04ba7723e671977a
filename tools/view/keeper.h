#pragma once

#include "vdblic/core/reporter.h"
#include "view/pictures.h"
#include "view/viewer.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

namespace vdblic::view {

/// Writes views, pictures and films into the folder in which the viewer was started, under free names:
/// view-001.transfer.json, view-001.camera.json, view-001.png, view-001.mp4.
///
/// Pictures and films are jobs, a few at a time, each in a thread of its own. A job is told as an object: its number
/// `job`, its `file`, samples or frames `done` of `total`, whether it is `finished`, and `error`, empty if it
/// succeeded.
class Keeper {
  public:
    Keeper(Viewer& viewer, Pictures& pictures) : mViewer(viewer), mPictures(pictures) {}
    Keeper(const Keeper&) = delete;
    Keeper& operator=(const Keeper&) = delete;

    /// Write transfer function and camera. @return their names as `files`, and `command`, which renders with them
    /// @throws OutputError, and as Viewer::view()
    [[nodiscard]] nlohmann::json keepFiles(const nlohmann::json& state, std::int64_t frame);
    /// Begin a picture. @param format png or exr  @return the job
    /// @throws ParameterError if it is impossible or too much is being made, InputError if it is too large
    [[nodiscard]] nlohmann::json beginPicture(const PictureRequest& request, const std::string& format);
    /// Begin a film of all frames. @return the job
    /// @throws ParameterError if one is being made, or on a bad rate
    [[nodiscard]] nlohmann::json beginFilm(const nlohmann::json& state, double framesPerSecond);
    /// End a job; one that is finished stays as it is. @throws ParameterError if there is none of this number
    void stop(std::int64_t job);
    /// The jobs that run and the last ones that are finished.
    [[nodiscard]] nlohmann::json jobs();

  private:
    class JobReporter;
    struct Job {
        nlohmann::json told;
        std::jthread thread;

        [[nodiscard]] bool isFinished() const { return told["finished"].get<bool>(); }
    };
    using Work = std::function<void(Reporter&, const std::stop_token&)>;

    /// A name for which no file has any of these endings and no job writes one.
    [[nodiscard]] std::string freeName() const;
    /// @param work told where to write, and @return what writes there. @throws ParameterError if too much is being made
    [[nodiscard]] nlohmann::json begin(const std::string& ending, std::size_t total,
                                       const std::function<Work(const std::string& file)>& work);

    Viewer& mViewer;
    Pictures& mPictures;
    std::mutex mMutex; // of names and jobs
    std::int64_t mNext = 1;
    std::list<Job> mJobs; // the newest last; their threads end first
};

} // namespace vdblic::view
