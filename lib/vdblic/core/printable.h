#pragma once

#include <string>
#include <string_view>

namespace vdblic {

/// A text of unknown origin for a terminal or a log: one line of valid UTF-8. Control characters, line ends, changes of
/// the writing direction and invalid UTF-8 become escapes as in C: `\n`, `\x1b`, `\u202e`. Idempotent.
[[nodiscard]] std::string printable(std::string_view text);

/// A word quoted for a shell, if it needs quotes.
[[nodiscard]] std::string shellWord(const std::string& word);

} // namespace vdblic
