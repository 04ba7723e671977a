#pragma once

#include "caller.h"
#include "vdblic/core/exchange.h"
#include "vdblic/run/texture_run.h"

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace vdblic::python {

/// The parameters of a run without its files.
[[nodiscard]] Parameters advectParameters(AdvectParams& params);

/// The textures of a velocity sequence, one after the other, from files or from volumes of Python, to volumes of
/// Python. Ctrl-C ends it before the next step. Not thread-safe.
class __attribute__((visibility("hidden"))) Textures : private RunObserver { // as what it holds
  public:
    /// @param frames an iterator over lists of grids as dictionaries and their metadata; None: files by `input`
    /// @param count  of the frames of the iterator; 0 if it is unknown
    /// @param tell   of a Caller; its progress is in steps
    /// @param ranks  of Ranks, whose iterators give parts of the frames; None: this process alone
    /// @param resume checkpoint of an iterator's run, whose last frame the iterator begins with; None: from the start
    Textures(const pybind11::dict& keywords, pybind11::object frames, std::size_t count, pybind11::function tell,
             const pybind11::object& ranks, std::optional<std::filesystem::path> resume);

    /// The next texture as grids and metadata, or None at the end. The grids of several ranks are at rank 0.
    [[nodiscard]] pybind11::object next();
    /// How many frames the iterator must have, unless it ends, before next() makes a texture.
    [[nodiscard]] int needed() const { return !mNext ? 2 : int(mRun->needsFrame()); }

    /// Write a checkpoint of the steps that are made. Collective. @param inputs texts that it holds
    /// @throws ParameterError if no step is made
    void save(const std::filesystem::path& path, const std::vector<std::string>& inputs);

  private:
    std::optional<RunPosition> begins(VelocitySequence& flow) override;
    void opened(const VelocityFrame& first, bool isOnly, FlowTexture& texture) override;
    void stepBegins() override { mStep.reset(); }
    void stepDone(const RunPosition& position, const VelocityFrame& next) override;
    void tellSteps(std::uint64_t done);
    void frameRead(const VelocityFrame& frame) override;
    [[nodiscard]] std::optional<TextureFile> make();
    [[nodiscard]] FrameSource source();
    [[nodiscard]] std::optional<FrameFile> nextFrame();

    std::optional<AdvectPlan> mPlan;
    pybind11::object mFrames;
    Caller mCaller;
    std::size_t mCount; // of frames; 0: unknown
    std::unique_ptr<Exchange> mExchange;
    std::optional<std::filesystem::path> mResume;
    std::optional<Checkpoint> mResumed; // until the run goes on from it
    std::istringstream mNoLines;        // of standard input
    std::optional<TextureRun> mRun;
    std::optional<TextureRun::Iterator> mNext; // nullopt before the first
    std::int64_t mTaken = 0;                   // frames of the iterator
    std::optional<std::int64_t> mFirst;
    struct Step {
        RunPosition position;
        VelocityFrame next; ///< that the next step starts from
    };
    std::optional<Step> mStep; // the last one
};

} // namespace vdblic::python
