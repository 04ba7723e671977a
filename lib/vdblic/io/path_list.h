#pragma once

#include <iosfwd>
#include <optional>
#include <string>

namespace vdblic {

/// The paths in a stream, in order. Line ends (LF, CR LF or CR) or NULs (`find -print0`) separate them: whichever comes
/// first in the stream. Empty ones are skipped.
class PathList {
  public:
    /// @param stream must outlive this
    explicit PathList(std::istream& stream) : mStream(stream) {}

    /// The next path, or nothing at the end.
    std::optional<std::string> next();

  private:
    [[nodiscard]] bool separates(char c);

    std::istream& mStream;
    std::optional<bool> mNul; // whether NULs separate, once known
};

} // namespace vdblic
