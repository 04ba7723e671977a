#pragma once

#include "vdblic/look/histogram.h"
#include "vdblic/render/shown_volume.h"
#include "vdblic/render/solid_maker.h"
#include "vdblic/render/view.h"
#include "view/files_on_disk.h"
#include "view/frame_cache.h"
#include "view/state.h"
#include "view/worker.h"

#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::view {

/// A frame and the view of it, from which pictures are cast.
struct FrameView {
    PicturePlan plan;
    View view;
    std::shared_ptr<const ShownVolume> shown;
    bool settled; ///< whether the picture is vdblic_render's: choices from all their frames, and no coarser copy
};

/// A sequence that is looked at. Any number of threads may ask at a time.
///
/// The automatic choices are the same as in vdblic_render. At first they are made from one frame, so that a picture is
/// there early; the others are read in the background. Of frames that the cache cannot hold, coarser copies beside them
/// are shown until the frame itself is read. If files of frames, or of lines in them, come, go or are replaced, the
/// choices follow once none has changed for a while.
class Viewer {
  public:
    /// @throws ParameterError, InputError if the sequence or what the start state says cannot be used
    Viewer(Start start, double cacheBytes);

    [[nodiscard]] const Start& start() const { return mStart; }
    /// The command that makes coarser copies, if the cache cannot hold the first frame and there are none; or empty.
    [[nodiscard]] std::string advice() const;
    /// The numbers of the selected frames on disk, which may become more or fewer.
    [[nodiscard]] std::vector<std::int64_t> frames();
    /// Rises with every change of frames, of automatic choices, or of a coarser copy for its frame.
    [[nodiscard]] std::uint64_t version();
    /// Names of the float grids beside the texture, and of the texture.
    [[nodiscard]] const std::vector<std::string>& scalars() const { return mStart.traits.scalars; }
    [[nodiscard]] const std::string& texture() const { return mStart.traits.texture; }

    /// @param settle wait until the automatic choices are settled and the frame itself is read
    /// @throws ParameterError on an impossible state or frame, InputError
    [[nodiscard]] FrameView view(const nlohmann::json& state, std::int64_t frame, bool settle = false);
    /// The camera in another direction that shows as much as the automatic one.
    /// @throws ParameterError on an impossible state or direction, InputError
    [[nodiscard]] Camera fitted(nlohmann::json state, const glm::dvec3& forward, const glm::dvec3& up);
    /// Settle a view in the background: read the frames that it still needs.
    void settleLater(const FrameView& view);
    /// Read a frame in the background.
    void prefetch(const nlohmann::json& state, std::int64_t frame);
    /// The lines of a frame as linePacket() has them; empty if it has voxels.
    /// @throws ParameterError on an impossible state or frame, InputError
    [[nodiscard]] std::string lines(const nlohmann::json& state, std::int64_t frame);
    /// Whether the first frame has lines.
    [[nodiscard]] bool hasLines() const { return mHasLines; }
    /// The histograms of the frames that the choices are made from.
    [[nodiscard]] TextureHistograms histograms(const nlohmann::json& state);

  private:
    struct Basis { // of automatic choices
        LookBasis look;
        std::vector<FrameFile> frames;
        bool settled = false;
    };
    struct Choice { // for a state without its camera
        Looks looks;
        std::vector<glm::dvec3> subject;
        bool hasSubject = false;
    };

    struct ShownLook { // a frame in a state without its camera
        std::string key;
        std::shared_ptr<const Basis> basis;
        std::shared_ptr<const ShownVolume> frame;
    };

    [[nodiscard]] FrameFile fileOf(std::int64_t frame);
    [[nodiscard]] FrameCache::Frame load(const PicturePlan& plan, const FrameFile& file);
    [[nodiscard]] FrameCache::Frame loadSoon(const PicturePlan& plan, const FrameFile& file);
    [[nodiscard]] std::optional<FrameFile> coarserCopy(const PicturePlan& plan, const FrameFile& file) const;
    [[nodiscard]] std::shared_ptr<const Basis> basisFor(const PicturePlan& plan, bool settle);
    [[nodiscard]] std::shared_ptr<const Basis> settledBasis(const PicturePlan& plan);
    void keepBasis(const std::string& key, const std::shared_ptr<const Basis>& basis);
    [[nodiscard]] Choice choiceFor(const PicturePlan& plan, const nlohmann::json& state,
                                   const std::shared_ptr<const Basis>& basis, const ViewSource& source);
    [[nodiscard]] std::shared_ptr<const ShownVolume> shownFor(const PicturePlan& plan, const nlohmann::json& state,
                                                              const Looks& looks, const FrameCache::Frame& frame,
                                                              const std::shared_ptr<const Basis>& basis);
    [[nodiscard]] ViewSource source(const glm::dvec3& stretch);
    void readSource();

    Start mStart;
    FrameCache mCache;
    bool mHasLines = false;

    std::mutex mMutex; // of the members below
    ViewSource mSource;
    std::vector<FileSeen> mFiles, mLineFiles;       // of the sequence, and of lines in its voxels
    std::chrono::steady_clock::time_point mChanged; // last change of these
    bool mSourceIsOld = false;                      // than these
    std::uint64_t mVersion = 1;
    std::list<std::pair<std::string, std::shared_ptr<const Basis>>> mBases;                      // the newest first
    std::list<std::pair<std::string, std::pair<std::shared_ptr<const Basis>, Choice>>> mChoices; // the newest first
    SolidMaker mSolids; // has a lock of its own
    ShownLook mShown;   // the newest one: a camera that moves shows the same

    Worker mBackground; // ends before what it uses
};

} // namespace vdblic::view
