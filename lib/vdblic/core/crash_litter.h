#pragma once

#include <cstddef>
#include <string>

namespace vdblic {

/// A file to remove if a parser's crash ends the process (crash_guard.h). At most four at a time; further ones are
/// ignored.
class CrashLitter {
  public:
    explicit CrashLitter(const std::string& path);
    ~CrashLitter();
    CrashLitter(const CrashLitter&) = delete;
    CrashLitter& operator=(const CrashLitter&) = delete;

  private:
    std::size_t mSlot;
};

/// Remove the registered files. Safe in a signal handler.
void removeCrashLitter() noexcept;

} // namespace vdblic
