#pragma once

#include <string>
#include <string_view>

namespace vdblic {

/// A text that may have come from a file, for a terminal or a log: one line of valid UTF-8. Control characters, those
/// that change the direction of writing, ends of lines and bytes that are no UTF-8 become escapes as in C: `\n`,
/// `\x1b`,
/// `\u202e`. All else stays, so a text that was made printable stays as it is.
[[nodiscard]] std::string printable(std::string_view text);

/// A word as a shell reads it back: in quotes where it has to be.
[[nodiscard]] std::string shellWord(const std::string& word);

} // namespace vdblic
