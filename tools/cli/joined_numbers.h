#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic::cli {

/// A command line in which up to three numbers after an option are one argument with commas between: `--refine 4 4
/// 2` becomes `--refine 4,4,2`. The parser would otherwise take a positional argument that follows for a further
/// number.
class JoinedNumbers {
  public:
    JoinedNumbers(int argc, char** argv, std::initializer_list<std::string_view> options);

    [[nodiscard]] int count() const { return int(mPointers.size()) - 1; }
    [[nodiscard]] char** arguments() { return mPointers.data(); } ///< ends with a null, as argv does

  private:
    std::vector<std::string> mTexts;
    std::vector<char*> mPointers;
};

} // namespace vdblic::cli
