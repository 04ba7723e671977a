#pragma once

#include <filesystem>
#include <set>
#include <utility>

#include <sys/types.h>

namespace vdblic {

/// The input files of a job: no output may replace one, under any name.
class InputFiles {
  public:
    /// @param input may be missing; an empty path is ignored
    void add(const std::filesystem::path& input);
    /// @throws ParameterError if the output is one of them
    void check(const std::filesystem::path& output) const;

  private:
    std::set<std::pair<dev_t, ino_t>> mFiles;
};

} // namespace vdblic
