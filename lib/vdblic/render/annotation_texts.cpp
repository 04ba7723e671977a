#include "vdblic/render/annotation_texts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <map>
#include <utility>

namespace vdblic {
namespace {

using Seconds = std::chrono::sys_seconds;

/// A date and time in ISO 8601, such as 2005-08-28T12:00:00; nullopt for any other text.
std::optional<Seconds> parseDate(const std::string& text)
{
    int year = 0;
    unsigned month = 0, day = 0, hour = 0, minute = 0, second = 0;
    const int read = std::sscanf(text.c_str(), "%d-%u-%u%*1[T ]%u:%u:%u", &year, &month, &day, &hour, &minute, &second);
    const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)};
    if ((read != 3 && read < 5) || !date.ok() || hour > 23 || minute > 59 || second > 60) return std::nullopt;
    return std::chrono::sys_days(date) + std::chrono::hours(hour) + std::chrono::minutes(minute) +
           std::chrono::seconds(second);
}

bool isWhole(double value)
{
    return std::abs(value - std::round(value)) < 1e-6 * std::max(1.0, std::abs(value));
}

std::string dateText(Seconds date, bool withSeconds)
{
    const auto day = std::chrono::floor<std::chrono::days>(date);
    const std::chrono::year_month_day ymd(day);
    const std::int64_t second = (date - day).count();
    std::string text = fmt::format("{:04}-{:02}-{:02} {:02}:{:02}", int(ymd.year()), unsigned(ymd.month()),
                                   unsigned(ymd.day()), second / 3600, second / 60 % 60);
    return withSeconds ? text + fmt::format(":{:02}", second % 60) : text;
}

/// Whole minutes as days, hours and minutes. @param longest of the sequence  @param wholeHours all of the sequence's
/// are
std::string minutesText(std::int64_t minutes, std::int64_t longest, bool wholeHours)
{
    const std::int64_t days = longest / 1440, hours = longest / 60;
    const std::string rest = wholeHours ? "" : fmt::format(" {:02} min", minutes % 60);
    if (days > 1) return fmt::format("{} d {:02} h{}", paddedText(minutes / 1440, days), minutes / 60 % 24, rest);
    if (hours > 0 || wholeHours) return fmt::format("{} h{}", paddedText(minutes / 60, hours), rest);
    return paddedText(minutes, longest) + " min";
}

/// With the decimals that multiples of a spacing need, one more than its first digit's at most.
/// @param width digits before the point, with zeros before the number
std::string secondsText(double value, double spacing, int width)
{
    int decimals = std::max(0, -int(std::floor(std::log10(spacing) + 1e-9)));
    if (!isWhole(spacing * std::pow(10, decimals))) ++decimals;
    return fmt::format("{:0{}.{}f}", value, decimals > 0 ? width + decimals + 1 : width, decimals);
}

/// Spaces as wide as digits.
std::string spaces(std::size_t count)
{
    std::string text;
    while (count-- > 0)
        text += "\u2007";
    return text;
}

struct Prefix {
    double seconds;
    const char* unit;
};

} // namespace

std::string clockText(const FrameClock& clock)
{
    if (!clock.time || !(std::abs(*clock.time) < 1e12)) return {};
    const double time = *clock.time;
    const double given = clock.dt.value_or(0);
    const double spacing = given > 0 && std::isfinite(given) ? given : time != 0 ? std::abs(time) : 1;
    const bool wholeMinutes = isWhole(spacing / 60) && isWhole(time / 60);
    if (const auto start = parseDate(clock.start)) {
        const auto date = *start + std::chrono::seconds(std::llround(time));
        return dateText(date, !wholeMinutes || (*start - Seconds()).count() % 60 != 0);
    }
    const std::string sign = time < 0 ? "-" : "";
    const double size = std::abs(time), longest = std::min(std::max(clock.longest, size), 1e12);
    if (wholeMinutes && spacing >= 60) {
        const bool wholeHours = isWhole(spacing / 3600) && isWhole(time / 3600);
        return sign + minutesText(std::llround(size / 60), std::llround(longest / 60), wholeHours);
    }
    if (longest >= 120) {
        const double shown = spacing >= 1 ? std::round(size) : size;
        const double minutes = std::floor(shown / 60);
        return fmt::format("{}{} {} s", sign,
                           minutesText(std::int64_t(minutes), std::int64_t(std::floor(longest / 60)), false),
                           secondsText(shown - 60 * minutes, std::clamp(spacing, 0.01, 1.0), 2));
    }
    constexpr Prefix kPrefixes[] = {{1, "s"}, {1e-3, "ms"}, {1e-6, "µs"}, {1e-9, "ns"}};
    // Seconds to a thousandth, and so on.
    const Prefix* prefix = std::begin(kPrefixes);
    while (spacing < 0.999e-3 * prefix->seconds && prefix + 1 != std::end(kPrefixes))
        ++prefix;
    const std::string text = secondsText(size / prefix->seconds, spacing / prefix->seconds, 1);
    const std::string widest = secondsText(longest / prefix->seconds, spacing / prefix->seconds, 1);
    return fmt::format("{}{}{} {}", spaces(widest.size() - std::min(widest.size(), text.size())), sign, text,
                       prefix->unit);
}

bool isGeographic(const FrameClock& clock, const std::string& lengthUnit, const glm::dvec3& stretch)
{
    const bool isSlow = clock.dt && *clock.dt >= 600;
    const bool isRaised = stretch.x == stretch.y && stretch.z > stretch.x;
    return (parseDate(clock.start) && lengthUnit == "m") || (isRaised && isSlow);
}

std::string paddedText(std::int64_t number, std::int64_t largest)
{
    const std::string text = std::to_string(number), widest = std::to_string(largest);
    return spaces(widest.size() - std::min(widest.size(), text.size())) + text;
}

std::string lengthText(double length, const std::string& unit)
{
    constexpr std::pair<double, const char*> kUnits[] = {{1e3, "km"}, {1, "m"}, {1e-3, "mm"}, {1e-6, "µm"}};
    if (unit == "m") {
        for (const auto& [factor, name] : kUnits) {
            if (length >= factor * (1 - 1e-9)) return fmt::format("{:.6g} {}", length / factor, name);
        }
    }
    constexpr double kShort = 1e-4, kLong = 1e9; // in between all digits are written
    if (length >= kShort && length < kLong) {
        std::string text = fmt::format("{:.10g}", length);
        const std::size_t point = std::min(text.find('.'), text.size());
        for (std::size_t at = point; at > 3 && point > 4; at -= 3)
            text.insert(at - 3, "\u202f");
        return unit.empty() ? text : text + " " + unit;
    }
    const AxisUnit shown = axisUnit(length, unit);
    return fmt::format("{:.6g}{}{}{}", length / shown.factor, shown.factor == 1 ? "" : " ×",
                       shown.text.empty() ? "" : " ", shown.text);
}

std::string scalarUnit(const std::string& name, const std::string& unit)
{
    static const std::map<std::string, std::string> kUnits = {{"vorticity", "1/s"}, {"q", "1/s²"}};
    const auto known = kUnits.find(name);
    return unit.empty() && known != kUnits.end() ? known->second : unit;
}

std::string scalarTitle(const std::string& name, const std::string& unit)
{
    static const std::map<std::string, std::string> kTerms = {{"magnitude", "speed"}, {"q", "Q criterion"}};
    const auto term = kTerms.find(name);
    const std::string& title = term != kTerms.end() ? term->second : name;
    return unit.empty() ? title : fmt::format("{} [{}]", title, unit);
}

AxisUnit axisUnit(double largest, const std::string& unit)
{
    constexpr double kLong = 1e4, kShort = 1e-2; // numbers beyond have many digits
    if (!(largest > 0)) return {1, unit};
    if (unit == "m") {
        if (largest >= kLong) return {1e3, "km"};
        if (largest >= 1) return {1, unit};
        return largest >= 1e-3 ? AxisUnit{1e-3, "mm"} : AxisUnit{1e-6, "µm"};
    }
    if (largest < kLong && largest >= kShort) return {1, unit};
    const double digits = std::log10(largest);
    const int thousands = largest >= kLong ? std::max(1, int(std::ceil((digits - std::log10(kLong)) / 3 - 1e-9)))
                                           : int(std::floor(digits / 3 + 1e-9));
    std::string power = "10";
    for (const char digit : std::to_string(3 * thousands)) {
        constexpr std::array<const char*, 10> kRaised = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
        power += digit == '-' ? "⁻" : kRaised[std::size_t(digit - '0')];
    }
    return {std::pow(10, 3 * thousands), unit.empty() ? power : power + " " + unit};
}

std::vector<double> roundNumbers(double low, double high, int wanted, double& step)
{
    const double rough = (high - low) / wanted, power = std::pow(10, std::floor(std::log10(rough)));
    step = power * (rough / power > 7 ? 10 : rough / power > 3 ? 5 : rough / power > 1.4 ? 2 : 1);
    std::vector<double> numbers;
    for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i)
        numbers.push_back(i * step);
    return numbers;
}

std::string tickText(double value, double step)
{
    const double shown = std::abs(value) < step * 1e-6 ? 0 : value;
    if (std::max(std::abs(value), step) >= 1e5 || step < 1e-4) return fmt::format("{:.3g}", shown);
    return fmt::format("{:.{}f}", shown, std::max(0, -int(std::floor(std::log10(step) + 1e-9))));
}

} // namespace vdblic
