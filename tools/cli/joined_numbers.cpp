#include "cli/joined_numbers.h"

#include "vdblic/core/parameters.h"

#include <algorithm>

namespace vdblic::cli {
namespace {

bool isNumber(std::string_view text)
{
    return detail::numberIn(text).has_value();
}

} // namespace

JoinedNumbers::JoinedNumbers(int argc, char** argv, std::initializer_list<std::string_view> options)
{
    constexpr int kMost = 3;
    for (int i = 0; i < argc; ++i) {
        mTexts.emplace_back(argv[i]);
        if (std::find(options.begin(), options.end(), mTexts.back()) == options.end() || i + 1 == argc) continue;
        std::string joined = argv[++i];
        for (int n = 1; n < kMost && isNumber(std::string_view(joined).substr(joined.rfind(',') + 1)) && i + 1 < argc;
             ++n) {
            if (!isNumber(argv[i + 1])) break;
            joined += ',' + std::string(argv[++i]);
        }
        mTexts.push_back(joined);
    }
    for (std::string& text : mTexts)
        mPointers.push_back(text.data());
    mPointers.push_back(nullptr);
}

} // namespace vdblic::cli
