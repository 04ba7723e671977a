#pragma once

#include "caller.h"
#include "vdblic/core/exchange.h"
#include "vdblic/run/texture_run.h"

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <sstream>

namespace vdblic::python {

/// The parameters of a run, except of its files.
[[nodiscard]] Parameters advectParameters(AdvectParams& params);

/// The textures of a velocity sequence, one after the other, from files or from volumes of Python, to volumes of
/// Python. Ctrl-C ends it before the next step. Not thread-safe.
class __attribute__((visibility("hidden"))) Textures : private RunObserver { // as what it holds
  public:
    /// @param frames an iterator over lists of grids as dictionaries and their metadata; None: files by `input`
    /// @param count  of the frames of the iterator; 0 if it is unknown
    /// @param tell   of a Caller; its progress is in steps
    Textures(const pybind11::dict& keywords, pybind11::object frames, std::size_t count, pybind11::function tell);

    /// The next texture as grids and metadata, or None at the end.
    [[nodiscard]] pybind11::object next();
    /// How many frames the iterator must have, unless it ends, before next() makes a texture.
    [[nodiscard]] int needed() const { return !mNext ? 2 : int(mRun->needsFrame()); }

  private:
    void stepDone(const RunPosition& position, const VelocityFrame& next) override;
    void tellSteps(std::uint64_t done);
    void frameRead(const VelocityFrame& frame) override;
    [[nodiscard]] FrameSource source();
    [[nodiscard]] std::optional<FrameFile> nextFrame();

    std::optional<AdvectPlan> mPlan;
    pybind11::object mFrames;
    Caller mCaller;
    std::size_t mCount; // of frames; 0: unknown
    OneProcess mAlone;
    std::istringstream mNoLines; // of standard input
    std::optional<TextureRun> mRun;
    std::optional<TextureRun::Iterator> mNext; // nothing before the first
    std::int64_t mTaken = 0;                   // frames of the iterator
    std::optional<std::int64_t> mFirst;
};

} // namespace vdblic::python
