#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace vdblic {

/// Thrown when the reporter asked the computation to stop. Finished outputs stay; nothing else was written.
struct Stopped {};

/// Progress and messages of a long computation, and requests to stop it. The default ignores all and never stops.
///
/// Called from one thread at a time; stopRequested() from any.
class Reporter {
  public:
    virtual ~Reporter() = default;

    /// `done` of `total` frames are finished; a total of 0 means unknown.
    virtual void progress(std::size_t /*done*/, std::size_t /*total*/) {}
    /// A detail for verbose output.
    virtual void detail(std::string_view /*message*/) {}
    /// A choice made on the user's behalf, or a result.
    virtual void say(std::string_view /*message*/) {}
    /// Something is probably wrong, but the work goes on.
    virtual void warn(std::string_view /*message*/) {}
    /// An output file is complete under its final name.
    virtual void finished(const std::filesystem::path& /*output*/) {}
    /// Whether to drop the current frame and all later ones.
    [[nodiscard]] virtual bool stopRequested() const { return false; }

    /// Called at least once a frame. @throws Stopped if a stop is requested
    void checkStop() const
    {
        if (stopRequested()) throw Stopped{};
    }
};

} // namespace vdblic
