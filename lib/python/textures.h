#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/run/texture_run.h"

#include <pybind11/pybind11.h>

#include <cstdint>
#include <exception>
#include <optional>
#include <sstream>

namespace vdblic::python {

/// The parameters of a run, except of its files.
[[nodiscard]] Parameters advectParameters(AdvectParams& params);

/// The textures of a velocity sequence, one after the other, from files or from volumes of Python, to volumes of
/// Python. Ctrl-C ends it before the next step. Not thread-safe.
class __attribute__((visibility("hidden"))) Textures : private Reporter, private RunObserver { // as what it holds
  public:
    /// @param frames an iterator over lists of grids as dictionaries and their metadata; None: files by `input`
    /// @param tell   called with a kind, `said` or `warned`, and a message
    Textures(const pybind11::dict& keywords, pybind11::object frames, pybind11::function tell);

    /// The next texture as grids and metadata, or None at the end.
    [[nodiscard]] pybind11::object next();

  private:
    void say(std::string_view message) override { tell("said", message); }
    void warn(std::string_view message) override { tell("warned", message); }
    [[nodiscard]] bool stopRequested() const override;
    void tell(const char* kind, std::string_view message);
    void frameRead(const VelocityFrame& frame) override;
    [[nodiscard]] FrameSource source();
    [[nodiscard]] std::optional<FrameFile> nextFrame();

    std::optional<AdvectPlan> mPlan;
    pybind11::object mFrames;
    pybind11::function mTell;
    OneProcess mAlone;
    std::istringstream mNoLines; // of standard input
    std::optional<TextureRun> mRun;
    std::optional<TextureRun::Iterator> mNext; // nothing before the first
    std::int64_t mTaken = 0;                   // frames of the iterator
    std::optional<std::int64_t> mFirst;
};

} // namespace vdblic::python
