#pragma once

#include <cstdint>
#include <string>

namespace vdblic {

/// Callbacks around the parsing of untrusted files by third-party code. With them a program's crash handler can
/// distinguish a damaged file from a bug (tools/cli).
///
/// The parsing thread calls enter() before and leave() after.
struct HazardHooks {
    void (*enter)(const char* file, std::uint64_t size, const char* library) noexcept = nullptr;
    void (*leave)() noexcept = nullptr;
};

/// Set the hooks of the process. Call it once, before the process has other threads. Like the signal handlers they
/// serve, the hooks are global.
void setHazardHooks(const HazardHooks& hooks);

/// Calls the hooks: this thread parses a file during the object's lifetime. Within the lifetime of another Hazard of
/// the same thread it does nothing.
class Hazard {
  public:
    static constexpr std::uint64_t kAnySize = std::uint64_t(1) << 60; ///< parsing may take any time

    /// @param file the file's path  @param size of the file in bytes
    /// @param library that parses it; must outlive this
    Hazard(const std::string& file, std::uint64_t size, const char* library = "OpenVDB");
    ~Hazard();
    Hazard(const Hazard&) = delete;
    Hazard& operator=(const Hazard&) = delete;
};

} // namespace vdblic
