#include "vdblic/core/printable.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>

namespace vdblic {
namespace {

struct Character {
    std::uint32_t code = 0;
    std::size_t bytes = 0; ///< 0 if the text does not begin with a character in UTF-8
};

/// The first character of a text that is not empty (RFC 3629).
Character firstOf(std::string_view text)
{
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
    const unsigned char head = byte(0);
    if (head < 0x80) return {head, 1};
    const std::size_t bytes = head >= 0xf0 ? 4 : head >= 0xe0 ? 3 : 2;
    constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000}; // by number of bytes
    if (head < 0xc0 || head > 0xf4 || text.size() < bytes) return {};
    std::uint32_t code = head & (0x7fU >> bytes);
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xc0U) != 0x80) return {};
        code = code << 6 | (byte(i) & 0x3fU);
    }
    const bool isSurrogate = code >= 0xd800 && code < 0xe000;
    return code < kLeast[bytes] || code > 0x10ffff || isSurrogate ? Character{} : Character{code, bytes};
}

/// Whether a character beyond ASCII controls the display: C1, ends of lines and paragraphs, directions of writing.
bool isControl(std::uint32_t code)
{
    constexpr std::uint32_t kRanges[][2] = {{0x80, 0x9f}, {0x200e, 0x200f}, {0x2028, 0x202e}, {0x2066, 0x2069}};
    return std::any_of(std::begin(kRanges), std::end(kRanges),
                       [code](const auto& range) { return code >= range[0] && code <= range[1]; });
}

} // namespace

std::string printable(std::string_view text)
{
    std::string result;
    result.reserve(text.size());
    while (!text.empty()) {
        const auto [code, bytes] = firstOf(text);
        if (bytes == 0) {
            result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
        } else if (code == '\n' || code == '\t' || code == '\r') {
            result += code == '\n' ? "\\n" : code == '\t' ? "\\t" : "\\r";
        } else if (code < ' ' || code == 0x7f) {
            result += fmt::format("\\x{:02x}", code);
        } else if (isControl(code)) {
            result += fmt::format("\\u{:04x}", code);
        } else {
            result += text.substr(0, bytes);
        }
        text.remove_prefix(std::max(bytes, std::size_t(1)));
    }
    return result;
}

std::string shellWord(const std::string& word)
{
    constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
    std::string result = "'";
    for (const char c : word)
        result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

} // namespace vdblic
