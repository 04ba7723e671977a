#pragma once

#include "view/keeper.h"
#include "view/pictures.h"
#include "view/viewer.h"
#include "view/web_server.h"

#include <nlohmann/json.hpp>

namespace vdblic::view {

/// What the page, or a script, asks the server: JSON in, JSON or a picture out. Requests go to paths below the viewer's
/// address; those with a body are POST requests of `application/json`. A state is an object with options of
/// vdblic_render by their names without dashes, {"look": "vortex", "eye": [1, 2, 3], "clip-plane": [[0, 0, 0, 1, 0,
/// 0]]}, and `keys` as in a file of key frames (docs/formats.md). An error has a status of 400 or more and the message
/// in `error`.
///
///     path        body                        answer
///     sequence                                frames, scalars, looks, colour maps, the start state;
///                                             `lines`: whether its first frame has lines
///     status                                  frames, `jobs`, and `version`, which rises when frames or choices change
///     scene       state, frame                automatic camera, ranges, points, values of the look, `clock` (time or
///                                             date), `colorTitle` (term and unit); `settled`: all frames were read
///                                             for it
///     histograms  state                       counts of texture and scalars
///     picture     state, frame, client, turn, a JPEG, or a PNG for "format": "png"; up to eight frames in `next` are
///                 quality, format, next,      read ahead; 204 if a request of the client with no lower `turn` arrived
///                 settle
///     fit         state, forward, up          the camera that sees all in this direction
///     rest        client, turn                the client's older pictures end
///     lines       state, frame                the frame's lines, as line_packet.h has them; 204 if it has voxels
///     thumbnail   state, frame                a JPEG of up to 160 pixels a side with one ray a pixel
///     command     state                       the command that renders it
///     keep        state, frame, kind: files   the names of the `files` and the `command`
///                 kind: picture (format)      a job: `job`, `file`, `done` of `total`, `finished`, `error`
///                 or film (fps)
///     stop        job                         ends a job
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
