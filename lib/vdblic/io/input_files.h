#pragma once

#include <filesystem>
#include <set>
#include <utility>

#include <sys/types.h>

namespace vdblic {

/// The files that a job reads, which none of its outputs may replace, by whatever name.
class InputFiles {
  public:
    /// @param input that need not exist; an empty path is none
    void add(const std::filesystem::path& input);
    /// @throws ParameterError if the output is one of them
    void check(const std::filesystem::path& output) const;

  private:
    std::set<std::pair<dev_t, ino_t>> mFiles;
};

} // namespace vdblic
