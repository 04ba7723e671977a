#include "vdblic/camera/clipping.h"

#include "vdblic/core/errors.h"
#include "vdblic/image/vector_text.h"

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdblic {
namespace {

bool finite(const glm::dvec3& v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

} // namespace

Parameters parametersOf(ClipParams& params)
{
    const auto vectorAt = [](const Words& words, std::size_t first) {
        return WordsOf<glm::dvec3>::read({words[first], words[first + 1], words[first + 2]});
    };
    const auto append = [](Words& words, const glm::dvec3& vector) {
        const Words more = WordsOf<glm::dvec3>::write(vector);
        words.insert(words.end(), more.begin(), more.end());
    };
    Parameter plane = parameter(
        "clip_plane", "Plane through a point, cutting away what its normal points away from; may be repeated.",
        WordType::kNumber, 6,
        [&params, vectorAt](const Words& words) {
            params.planes.clear();
            for (std::size_t i = 0; i < words.size(); i += 6)
                params.planes.push_back({vectorAt(words, i), vectorAt(words, i + 3)});
        },
        [&params, append] {
            Words words;
            for (const auto& [point, normal] : params.planes) {
                append(words, point);
                append(words, normal);
            }
            return words;
        },
        {.unit = "world", .words = "X Y Z NX NY NZ"});
    plane.repeats = true;
    const Parameter box = parameter(
        "clip_box", "Low and high corner of a box, cutting away what is outside.", WordType::kNumber, 6,
        [&params, vectorAt](const Words& words) {
            params.box = {vectorAt(words, 0), vectorAt(words, 3)};
        },
        [&params, append] {
            Words words;
            for (int corner = 0; params.box && corner < 2; ++corner)
                append(words, (*params.box)[std::size_t(corner)]);
            return words;
        },
        {.unit = "world", .words = "X Y Z X Y Z"});
    return {plane, box};
}

double ClipPlane::height(const glm::dvec3& at) const
{
    return glm::dot(at - point, normal);
}

bool isCutAway(const std::array<glm::dvec3, 8>& corners, std::span<const ClipPlane> planes)
{
    return std::any_of(planes.begin(), planes.end(), [&](const ClipPlane& plane) {
        return std::all_of(corners.begin(), corners.end(),
                           [&](const glm::dvec3& corner) { return plane.height(corner) <= 0; });
    });
}

void ClipParams::validate() const
{
    for (const auto& [point, normal] : planes) {
        if (!finite(point) || !finite(normal) || !(glm::length(normal) > 0)) {
            throw ParameterError(
                fmt::format("clip plane {} {} {}  {} {} {} must be a point and a normal that is not zero", point.x,
                            point.y, point.z, normal.x, normal.y, normal.z));
        }
    }
    if (!box) return;
    const auto& [low, high] = *box;
    if (!finite(low) || !finite(high) || !(low.x < high.x && low.y < high.y && low.z < high.z)) {
        throw ParameterError(fmt::format("clip box {} {} {}  {} {} {} must be a low and a high corner", low.x, low.y,
                                         low.z, high.x, high.y, high.z));
    }
}

std::vector<ClipPlane> ClipParams::allPlanes() const
{
    std::vector<ClipPlane> all = planes;
    if (!box) return all;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 inward(0);
        inward[axis] = 1;
        all.push_back({(*box)[0], inward});
        all.push_back({(*box)[1], -inward});
    }
    return all;
}

ClipParams ClipParams::stretched(const glm::dvec3& factors) const
{
    ClipParams result = *this;
    for (auto& [point, normal] : result.planes) {
        point *= factors;
        normal /= factors;
    }
    if (result.box) {
        for (glm::dvec3& corner : *result.box)
            corner *= factors;
    }
    return result;
}

} // namespace vdblic
