#pragma once

#include "vdblic/core/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdblic {

/// A parameter's value as texts: one for a number or a name, several for a vector or a list, none if it is not given.
using Words = std::vector<std::string>;

/// The type of a parameter's words.
enum class WordType { kFlag, kInteger, kNumber, kText };

/// Bounds of numbers.
struct Limits {
    double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    bool isAbove = false; ///< whether `least` itself is refused
};

/// Unit, limits and spelling of a parameter.
struct ParameterInfo {
    std::string_view option{}; ///< of tools; empty: the key with dashes; without dashes: a positional argument
    std::string_view unit{};
    std::string_view words{}; ///< placeholders of its words: `X Y Z`
    Limits limits{};
    bool isRequired = false;
    std::string_view excludes{}; ///< key of a parameter that cannot be given beside it
};

/// A described parameter of a struct. Options, help, keywords, checkpoints, image headers and documents are made from
/// it, so each stands in one place.
struct Parameter {
    std::string_view key;  ///< its name in messages, in Python and in checkpoints: `life_span`
    std::string_view text; ///< what it does, in a sentence or two
    ParameterInfo info{};
    WordType type = WordType::kText;
    std::size_t least = 1, most = 1; ///< words of a value
    bool repeats = false;            ///< whether values of `least` words may follow each other
    std::vector<std::string> choices{};
    std::function<void(const Words&)> set; ///< @throws ParameterError
    std::function<Words()> get;

    [[nodiscard]] std::string option() const; ///< `--life`, or `-o,--output`, or `VELOCITY`
    [[nodiscard]] bool isPositional() const { return !option().starts_with('-'); }
    [[nodiscard]] bool isList() const { return most > least; }
    /// The values allowed: "a whole number from 1 to 1000".
    [[nodiscard]] std::string kind() const;
    /// @throws ParameterError if words are missing, too many, not numeric or out of bounds
    void check(const Words& words) const;
    /// The value as one text, as in messages and files; empty if not given.
    [[nodiscard]] std::string value() const;
};

/// The parameters of a struct, in the order in which they are set. They refer to it, and it must outlive them.
using Parameters = std::vector<Parameter>;

[[nodiscard]] Parameters joined(std::initializer_list<Parameters> lists);
/// The parameter of a key, or null.
[[nodiscard]] const Parameter* find(const Parameters& parameters, std::string_view key);
/// Check all values against their bounds. @throws ParameterError
void checkLimits(const Parameters& parameters);
/// Set the given parameters by key. @throws ParameterError, also on unknown keys
void set(const Parameters& parameters, const std::map<std::string, Words>& given);

/// One line for each value of a plan that is given or differs from its default: "plan: `size` 64 48 (given)".
/// @param defaults, said, plan the same parameters: default, as the user gave them, as used
/// @param chooser  the source of a value that the user did not give, by its parameter in the plan
[[nodiscard]] std::vector<std::string> planLines(
    const Parameters& defaults, const Parameters& said, const Parameters& plan,
    const std::function<std::string(const Parameter&)>& chooser = [](const auto&) { return "chosen"; });

/// Conversion of a type to and from words. Vectors of other libraries specialise it.
template<typename T>
struct WordsOf;

namespace detail {

[[nodiscard]] std::optional<double> numberIn(std::string_view word);
[[nodiscard]] std::optional<std::int64_t> integerIn(std::string_view word);

template<typename T>
T scalarIn(const std::string& word)
{
    if constexpr (std::is_same_v<T, std::string>) {
        return word;
    } else if constexpr (std::is_enum_v<T>) {
        return valueOf<T>(word);
    } else if constexpr (std::is_same_v<T, bool>) {
        return word == "true";
    } else if constexpr (std::is_integral_v<T>) {
        return static_cast<T>(integerIn(word).value_or(0));
    } else if constexpr (std::is_same_v<T, float>) {
        return std::strtof(word.c_str(), nullptr); // not by way of double, which would round twice
    } else {
        return static_cast<T>(numberIn(word).value_or(0));
    }
}
template<typename T>
std::string wordOf(const T& value)
{
    if constexpr (std::is_enum_v<T>) {
        return std::string(nameOf(value));
    } else {
        return fmt::format("{}", value);
    }
}
template<typename T>
constexpr WordType kTypeOf = std::is_same_v<T, bool>       ? WordType::kFlag
                             : std::is_integral_v<T>       ? WordType::kInteger
                             : std::is_floating_point_v<T> ? WordType::kNumber
                                                           : WordType::kText;

} // namespace detail

template<typename T>
requires std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string>
struct WordsOf<T> {
    using Scalar = T;
    static constexpr std::size_t kLeast = 1, kMost = 1;
    static T read(const Words& words) { return detail::scalarIn<T>(words.front()); }
    static Words write(const T& value)
    {
        const std::string word = detail::wordOf(value);
        return word.empty() ? Words{} : Words{word};
    }
};
template<typename T>
struct WordsOf<std::optional<T>> {
    using Scalar = typename WordsOf<T>::Scalar;
    static constexpr std::size_t kLeast = WordsOf<T>::kLeast, kMost = WordsOf<T>::kMost;
    static std::optional<T> read(const Words& words) { return WordsOf<T>::read(words); }
    static Words write(const std::optional<T>& value) { return value ? WordsOf<T>::write(*value) : Words{}; }
};
template<typename T, std::size_t kCount>
struct WordsOf<std::array<T, kCount>> {
    using Scalar = T;
    static constexpr std::size_t kLeast = kCount, kMost = kCount;
    static std::array<T, kCount> read(const Words& words)
    {
        std::array<T, kCount> values;
        for (std::size_t i = 0; i < kCount; ++i)
            values[i] = detail::scalarIn<T>(words[i]);
        return values;
    }
    static Words write(const std::array<T, kCount>& values)
    {
        Words words;
        for (const T& value : values)
            words.push_back(detail::wordOf(value));
        return words;
    }
};
template<>
struct WordsOf<std::vector<std::string>> {
    using Scalar = std::string;
    static constexpr std::size_t kLeast = 1, kMost = std::numeric_limits<std::size_t>::max();
    static std::vector<std::string> read(const Words& words) { return words; }
    static Words write(const std::vector<std::string>& values) { return values; }
};

/// Describe a member of a struct.
template<typename T>
[[nodiscard]] Parameter parameter(std::string_view key, std::string_view text, T& target,
                                  const ParameterInfo& info = {})
{
    using Conversion = WordsOf<T>;
    using Scalar = typename Conversion::Scalar;
    Parameter result{key, text, info, detail::kTypeOf<Scalar>, Conversion::kLeast, Conversion::kMost};
    if constexpr (std::is_integral_v<Scalar> && sizeof(Scalar) < sizeof(std::int64_t)) {
        result.info.limits.least = std::max(info.limits.least, double(std::numeric_limits<Scalar>::min()));
        result.info.limits.most = std::min(info.limits.most, double(std::numeric_limits<Scalar>::max()));
    }
    if constexpr (std::is_enum_v<Scalar>) result.choices.assign(kNames<Scalar>.begin(), kNames<Scalar>.end());
    result.set = [&target](const Words& words) { target = Conversion::read(words); };
    result.get = [&target] { return Conversion::write(target); };
    return result;
}

/// Describe a parameter that is no member of a struct.
/// @param count words of a value
[[nodiscard]] inline Parameter parameter(std::string_view key, std::string_view text, WordType type, std::size_t count,
                                         std::function<void(const Words&)> set, std::function<Words()> get,
                                         const ParameterInfo& info = {})
{
    return {key, text, info, type, count, count, false, {}, std::move(set), std::move(get)};
}

} // namespace vdblic
