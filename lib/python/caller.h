#pragma once

#include "vdblic/core/reporter.h"

#include <pybind11/pybind11.h>

#include <cstddef>
#include <string_view>
#include <utility>

namespace vdblic::python {

/// The Python caller: receives progress and messages, and stops a computation on Ctrl-C. Usable without Python's lock.
class __attribute__((visibility("hidden"))) Caller : public Reporter { // as the function it holds
  public:
    /// @param tell called with `said` or `warned` and a message, or with `progress`, the steps done and their number
    explicit Caller(pybind11::function tell) : mTell(std::move(tell)) {}

    void progress(std::size_t done, std::size_t total) override;
    void say(std::string_view message) override { tell("said", message); }
    void warn(std::string_view message) override { tell("warned", message); }
    /// @throws pybind11::error_already_set if a signal handler raised
    [[nodiscard]] bool stopRequested() const override;

  private:
    void tell(const char* kind, std::string_view message);

    pybind11::function mTell;
};

} // namespace vdblic::python
