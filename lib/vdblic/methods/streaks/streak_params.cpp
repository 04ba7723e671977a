#include "vdblic/methods/streaks/streak_params.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace vdblic {
namespace {

constexpr double kMostSpacing = 1e6, kMostTail = 1000;
constexpr std::size_t kMostSources = 16;

/// The parameter `spacing`: one number, or one for each axis.
Parameter spacingParameter(StreakParams& params)
{
    const auto read = [&params](const Words& words) {
        if (words.size() == 2) throw ParameterError("`spacing` takes one number, or one for each of the three axes");
        std::array<float, 3> spacing{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            spacing[axis] = detail::scalarIn<float>(words[words.size() == 1 ? 0 : axis]);
        params.spacing = spacing;
    };
    const auto write = [&params]() -> Words {
        if (!params.spacing) return {};
        const auto& [x, y, z] = *params.spacing;
        if (x == y && y == z) return {fmt::format("{}", x)};
        return {fmt::format("{}", x), fmt::format("{}", y), fmt::format("{}", z)};
    };
    Parameter result = parameter(
        "spacing", "Distance between streaks, or one for each axis. By default as many streaks as a picture holds.",
        WordType::kNumber, 1, read, write,
        {.unit = "voxels of the velocity", .words = "S or SX SY SZ", .limits = {0, kMostSpacing, true}});
    result.most = 3;
    return result;
}

} // namespace

Parameters parametersOf(StreakParams& params)
{
    return {
        spacingParameter(params),
        parameter("tail",
                  "How far back a streak shows its path. By default the faster half of the flow has tails of six "
                  "spacings.",
                  params.tail, {.unit = "frames", .limits = {0, kMostTail, true}}),
        parameter(
            "draw",
            "What streaks are drawn as: voxels, for programs that know volumes alone, or lines: OpenVDB points, crisp "
            "from near, a tenth of the size.",
            params.draw, {.words = "FORM"}),
        parameter("emit",
                  "Release streaks only where a grid is above 0 (a level set: below), as smoke in a wind tunnel.",
                  params.emit, {.words = "FILE[:GRID]"}),
        parameter("emit_box", "Release streaks only in a box of world space: low and high corner.", params.emitBox,
                  {.words = "X Y Z X Y Z", .excludes = "emit"}),
        parameter("source",
                  "A region whose air is followed: a streak that was in it has its number in the grid `source`. The "
                  "regions are numbered from 1 as they are given.",
                  params.sources, {.words = "NAME=FILE[:GRID]"}),
    };
}

bool StreakParams::areGiven() const
{
    return spacing || tail || draw != StreakForm{} || emits() || !sources.empty();
}

void StreakParams::validate() const
{
    StreakParams copy = *this;
    checkLimits(parametersOf(copy));
    if (!emit.empty() && emitBox) throw ParameterError("`emit` and `emit_box` exclude each other");
    for (std::size_t axis = 0; emitBox && axis < 3; ++axis) {
        if ((*emitBox)[axis] <= (*emitBox)[axis + 3]) continue;
        throw ParameterError(fmt::format("`emit_box`: the lower corner {} is above the upper one {} along axis {}",
                                         (*emitBox)[axis], (*emitBox)[axis + 3], axis));
    }
    (void)sourcesOf(*this);
}

std::vector<StreakSource> sourcesOf(const StreakParams& params)
{
    std::vector<StreakSource> sources;
    for (const std::string& text : params.sources) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
            throw ParameterError(fmt::format("`source` {}: give NAME=FILE or NAME=FILE:GRID", text));
        const std::string name = text.substr(0, equals);
        const bool isThere =
            std::any_of(sources.begin(), sources.end(), [&](const StreakSource& one) { return one.name == name; });
        if (isThere) throw ParameterError(fmt::format("`source`: the name {} stands twice", name));
        sources.push_back({name, text.substr(equals + 1)});
    }
    if (sources.size() > kMostSources)
        throw ParameterError(fmt::format("`source`: {} regions are more than {}", sources.size(), kMostSources));
    return sources;
}

} // namespace vdblic
