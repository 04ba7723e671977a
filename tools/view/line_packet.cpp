#include "view/line_packet.h"

#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace vdblic::view {
namespace {

constexpr std::uint32_t kNow = 65534; // time of heads

/// Consecutive points of a line.
struct Run {
    std::uint32_t id, first, count;
};

std::vector<Run> runsOf(const Tubes& tubes, std::uint32_t part)
{
    std::vector<Run> runs;
    for (const Tubes::Cone& cone : tubes.cones()) {
        const auto id = std::uint32_t(cone.line);
        if (id % part != 0) continue;
        if (cone.hasPrevious)
            ++runs.back().count;
        else
            runs.push_back({id, cone.first, 2});
    }
    return runs;
}

std::size_t pointsOf(const std::vector<Run>& runs)
{
    std::size_t points = 0;
    for (const Run& run : runs)
        points += run.count;
    return points;
}

/// A share of 65535. @param share of 1; clamped
std::uint16_t stepOf(double share)
{
    return std::uint16_t(share > 0 ? std::lround(std::min(share, 1.0) * 65535) : 0);
}

template<typename Value>
void append(std::string& bytes, const std::vector<Value>& values)
{
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
}

/// A column of what a function tells of each point.
/// @param tell (run, number of the point)
template<typename Value, typename Tell>
void appendPoints(std::string& bytes, const std::vector<Run>& runs, const Tell& tell)
{
    std::vector<Value> values;
    values.reserve(pointsOf(runs));
    for (const Run& run : runs) {
        for (std::uint32_t i = run.first; i < run.first + run.count; ++i)
            values.push_back(Value(tell(run, i)));
    }
    append(bytes, values);
}

template<typename Value, typename Tell>
void appendLines(std::string& bytes, const std::vector<Run>& runs, const Tell& tell)
{
    std::vector<Value> values;
    values.reserve(runs.size());
    for (const Run& run : runs)
        values.push_back(Value(tell(run)));
    append(bytes, values);
}

/// A column of a scalar. A missing value is that of the next point, else of the one before.
void appendScalars(std::string& bytes, const std::vector<Run>& runs, const std::vector<float>& values)
{
    appendPoints<float>(bytes, runs, [&](const Run& run, std::uint32_t i) {
        if (!std::isnan(values[i])) return values[i];
        return i + 1 < run.first + run.count && !std::isnan(values[i + 1]) ? values[i + 1]
                                                                           : values[std::max(i, run.first + 1) - 1];
    });
}

/// Places along lines by how opacity falls towards the tail, each later than the one before.
void appendTimes(std::string& bytes, const std::vector<Run>& runs, const std::vector<float>& heads,
                 const std::vector<float>& opacities)
{
    std::vector<std::uint16_t> times;
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const auto [id, first, count] = runs[r];
        const double last = std::max(double(kNow) - count, 0.0);
        std::uint32_t before = 0;
        for (std::uint32_t i = first; i < first + count; ++i) {
            const double share = heads[r] > 0 ? std::clamp(double(opacities[i] / heads[r]), 0.0, 1.0) : 1;
            before = i + 1 == first + count ? kNow : std::min(std::max(std::uint32_t(share * last), before + 1), kNow);
            times.push_back(std::uint16_t(before));
        }
    }
    append(bytes, times);
}

} // namespace

std::string linePacket(const Tubes& tubes, const Corners& box, std::size_t most)
{
    std::uint32_t part = 1;
    std::vector<Run> runs = runsOf(tubes, part);
    while (pointsOf(runs) > most && part < 1U << 30)
        runs = runsOf(tubes, part *= 2);
    const glm::dmat4 toWorld = glm::inverse(tubes.worldToTubes());
    const Tubes::Point* const points = runs.empty() ? nullptr : tubes.points(0) - tubes.cones().front().first;
    const auto placeOf = [&](std::uint32_t i) {
        return glm::dvec3(toWorld * glm::dvec4(points[i].x, points[i].y, points[i].z, 1));
    };
    glm::dvec3 low = box.front(), high = low;
    const auto include = [&](const glm::dvec3& place) {
        if (!std::isfinite(place.x + place.y + place.z)) return;
        low = glm::min(low, place);
        high = glm::max(high, place);
    };
    for (const glm::dvec3& corner : box)
        include(corner);
    float radius = 0;
    std::vector<float> heads;
    for (const Run& run : runs) {
        heads.push_back(0);
        for (std::uint32_t i = run.first; i < run.first + run.count; ++i) {
            include(placeOf(i));
            radius = std::max(radius, points[i].radius);
            heads.back() = std::max(heads.back(), std::min(tubes.opacities()[i], 1.0f));
        }
    }
    const bool hasColor = !tubes.colors().empty();
    std::string told = nlohmann::json{
        {"points", pointsOf(runs)},
        {"lines", runs.size()},
        {"part", part},
        {"low", {low.x, low.y, low.z}},
        {"high", {high.x, high.y, high.z}},
        {"radius", double(radius) / tubes.unitsPerWorld()},
        {"hasColor",
         hasColor}}.dump();
    told.resize((told.size() + 3) / 4 * 4, ' ');
    std::string bytes;
    append(bytes, std::vector{std::uint32_t(told.size())});
    bytes += told;
    appendScalars(bytes, runs, tubes.drivers());
    if (hasColor) appendScalars(bytes, runs, tubes.colors());
    appendLines<std::uint32_t>(bytes, runs, [](const Run& run) { return run.id; });
    appendLines<std::uint32_t>(bytes, runs, [](const Run& run) { return run.count; });
    for (int axis = 0; axis < 3; ++axis) {
        const double side = high[axis] > low[axis] ? high[axis] - low[axis] : 1;
        appendPoints<std::uint16_t>(
            bytes, runs, [&](const Run&, std::uint32_t i) { return stepOf((placeOf(i)[axis] - low[axis]) / side); });
    }
    appendTimes(bytes, runs, heads, tubes.opacities());
    std::vector<std::uint16_t> own;
    own.reserve(heads.size());
    for (const float head : heads)
        own.push_back(stepOf(head));
    append(bytes, own);
    return bytes;
}

} // namespace vdblic::view
