#pragma once

#include <filesystem>
#include <string_view>

namespace vdblic {

/// What a long computation tells its caller while it runs; the default listens to nothing.
///
/// Called from one thread at a time.
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
};

} // namespace vdblic
