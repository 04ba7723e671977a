#pragma once

#include <cstddef>
#include <string>

namespace vdblic {

/// A file that goes with the process where a crash of a parser ends it (crash_guard.h). At most four at a time; of
/// further ones nothing is remembered.
class CrashLitter {
  public:
    explicit CrashLitter(const std::string& path);
    ~CrashLitter();
    CrashLitter(const CrashLitter&) = delete;
    CrashLitter& operator=(const CrashLitter&) = delete;

  private:
    std::size_t mSlot;
};

/// For handlers of signals.
void removeCrashLitter() noexcept;

} // namespace vdblic
