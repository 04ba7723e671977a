#pragma once

#include <cstdint>
#include <string>

namespace vdblic {

/// What a program wants to be told when a thread begins and ends to have a file parsed by code that is not ours and
/// was not made for hostile bytes. A program's crash handler can so tell a damaged file from a bug (tools/cli).
///
/// Both are called by the thread that parses, enter() before and leave() after, and must not throw.
struct HazardHooks {
    void (*enter)(const char* file, std::uint64_t size) noexcept = nullptr;
    void (*leave)() noexcept = nullptr;
};

/// Set the process's hooks, once, before it has other threads. Like the signal handlers they serve there is one set to
/// a process: the one thing in this library that is.
void setHazardHooks(const HazardHooks& hooks);

/// While it lives, this thread has a file parsed.
class Hazard {
  public:
    /// @param file that is parsed  @param size in bytes
    Hazard(const std::string& file, std::uint64_t size);
    ~Hazard();
    Hazard(const Hazard&) = delete;
    Hazard& operator=(const Hazard&) = delete;
};

} // namespace vdblic
