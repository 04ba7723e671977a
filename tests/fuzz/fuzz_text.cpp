/// Any text as user input; the first byte selects the parser.
#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/transfer_params.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

namespace {

void requireAscending(const std::vector<std::int64_t>& frames)
{
    if (frames.empty() || frames.size() > vdblic::kMaxFrames) std::abort();
    for (std::size_t i = 1; i < frames.size(); ++i) {
        if (frames[i] <= frames[i - 1]) std::abort();
    }
}

void requireSameFrame(const vdblic::FramePattern& pattern)
{
    // A pattern's paths contain the frame number they were made from.
    for (const std::int64_t frame : {0, 7, 123456}) {
        if (pattern.path(frame).string().find(std::to_string(frame)) == std::string::npos) std::abort();
    }
}

void parse(char what, std::string_view text)
{
    switch (what) {
    case 'f':
        requireAscending(vdblic::parseFrameList(text));
        break;
    case 'p': {
        const vdblic::FramePattern pattern(text);
        if (pattern.hasField()) requireSameFrame(pattern);
        break;
    }
    case 'n':
        (void)vdblic::frameOfName(text);
        break;
    case 'g':
        if (vdblic::parseGridReference(text).path.empty()) std::abort();
        break;
    case 'o':
        for (const vdblic::OpacityPoint& point : vdblic::parseOpacity(text)) {
            if (!(point.position >= 0 && point.position <= 1 && point.opacity >= 0 && point.opacity <= 1)) std::abort();
        }
        break;
    case 'c':
        for (const vdblic::ColorPoint& point : vdblic::parseColors(text)) {
            if (!(point.position >= 0 && point.position <= 1 && point.color.r >= 0 && point.color.b <= 1)) std::abort();
        }
        break;
    case 'm':
        if (vdblic::parseMemory(text) == 0) std::abort();
        break;
    default:
        break;
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    // A list of a few characters may select 999,999 frames; long lists of such parts are slow to expand.
    constexpr std::size_t kLongest = 200;
    if (size == 0 || size > kLongest) return 0;
    try {
        parse(char(data[0]), {reinterpret_cast<const char*>(data + 1), size - 1});
    } catch (const vdblic::ParameterError&) {
    }
    return 0;
}
