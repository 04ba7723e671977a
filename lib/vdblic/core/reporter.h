#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace vdblic {

/// A computation ended because its reporter asked it to. Outputs finished before stay; nothing else was written.
struct Stopped {};

/// What a long computation tells its caller while it runs, and asks it; the default listens to nothing and never stops.
///
/// Called from one thread at a time; stopRequested() from any.
class Reporter {
  public:
    virtual ~Reporter() = default;

    /// `done` of `total` frames are finished; total 0 means not known yet.
    virtual void progress(std::size_t /*done*/, std::size_t /*total*/) {}
    /// A detail for those who asked for more.
    virtual void detail(std::string_view /*message*/) {}
    /// A choice made for the user that should be known.
    virtual void say(std::string_view /*message*/) {}
    /// Something is likely wrong, yet the work goes on.
    virtual void warn(std::string_view /*message*/) {}
    /// An output file is complete under its final name.
    virtual void finished(const std::filesystem::path& /*output*/) {}
    /// Whether to give up the frame that is being computed and all that follow.
    [[nodiscard]] virtual bool stopRequested() const { return false; }

    /// Asked at least once a frame. @throws Stopped if a stop is requested
    void checkStop() const
    {
        if (stopRequested()) throw Stopped{};
    }
};

} // namespace vdblic
