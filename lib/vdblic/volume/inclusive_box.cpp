#include "vdblic/volume/inclusive_box.h"

#include "vdblic/field/vector.h"

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>

namespace vdblic {
namespace {

constexpr int kDirections = 128;

/// Directions spread evenly over the sphere: Fibonacci's lattice.
glm::dvec3 evenDirection(int i)
{
    const double z = 1 - (2 * i + 1.0) / kDirections, angle = 2 * std::numbers::pi * std::numbers::phi * i;
    return {std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z};
}

bool isBefore(const InclusiveBox& a, const InclusiveBox& b)
{
    const auto key = [](const InclusiveBox& box) {
        return std::array{box.low[0], box.low[1], box.low[2], box.high[0], box.high[1], box.high[2]};
    };
    const auto inA = key(a), inB = key(b);
    return std::lexicographical_compare(inA.begin(), inA.end(), inB.begin(), inB.end());
}

/// The faces of boxes, eight boxes at a time; the last one fills up its eight.
class BoxFaces {
  public:
    explicit BoxFaces(const std::vector<InclusiveBox>& boxes)
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (const bool isHigh : {false, true}) {
                std::vector<float>& faces = mFaces[axis][std::size_t(isHigh)];
                faces.reserve(boxes.size() + kLanes - 1);
                for (const InclusiveBox& box : boxes)
                    faces.push_back(isHigh ? float(box.high[axis]) + 0.5f : float(box.low[axis]) - 0.5f);
                faces.resize((boxes.size() + kLanes - 1) / kLanes * kLanes, faces.back());
            }
        }
    }

    /// The boxes that reach farthest in a direction, by number.
    [[nodiscard]] std::vector<std::size_t> farthest(const glm::dvec3& direction) const;

  private:
    std::vector<float> mFaces[3][2]; // by axis; the low and the high ones
};

VDBLIC_KERNEL
std::vector<std::size_t> BoxFaces::farthest(const glm::dvec3& direction) const
{
    const float* faces[3];
    for (int axis = 0; axis < 3; ++axis)
        faces[axis] = mFaces[axis][direction[axis] > 0].data();
    const glm::vec3 along(direction);
    const auto reach = [&](std::size_t first) {
        Float8 at[3];
        for (int axis = 0; axis < 3; ++axis)
            std::memcpy(&at[axis], faces[axis] + first, sizeof at[axis]);
        return along.x * at[0] + along.y * at[1] + along.z * at[2];
    };
    const std::size_t count = mFaces[0][0].size();
    Float8 most = reach(0);
    for (std::size_t first = kLanes; first < count; first += kLanes) {
        const Float8 here = reach(first);
        most = here > most ? here : most;
    }
    float farthest = most[0];
    for (int lane = 1; lane < kLanes; ++lane)
        farthest = std::max(farthest, most[lane]);
    std::vector<std::size_t> found;
    for (std::size_t first = 0; first < count; first += kLanes) {
        for (unsigned left = bitsOf(reach(first) == farthest); left != 0; left &= left - 1)
            found.push_back(first + std::size_t(__builtin_ctz(left)));
    }
    return found;
}

} // namespace

std::array<glm::dvec3, 8> InclusiveBox::corners(const glm::dmat4& indexToWorld) const
{
    std::array<glm::dvec3, 8> result;
    for (unsigned i = 0; i < 8; ++i) {
        glm::dvec4 corner(0, 0, 0, 1);
        for (int axis = 0; axis < 3; ++axis)
            corner[axis] = i >> axis & 1 ? high[std::size_t(axis)] + 0.5 : low[std::size_t(axis)] - 0.5;
        result[i] = glm::dvec3(indexToWorld * corner);
    }
    return result;
}

std::vector<InclusiveBox> outermost(const std::vector<InclusiveBox>& boxes, const glm::dvec3& extent)
{
    if (boxes.empty()) return {};
    const BoxFaces faces(boxes);
    std::vector<InclusiveBox> found(kDirections);
    tbb::parallel_for(0, kDirections, [&](int i) {
        const std::vector<std::size_t> all = faces.farthest(evenDirection(i) / extent);
        const auto box = [&](std::size_t number) { return boxes[std::min(number, boxes.size() - 1)]; };
        found[std::size_t(i)] = box(*std::min_element(
            all.begin(), all.end(), [&](std::size_t a, std::size_t b) { return isBefore(box(a), box(b)); }));
    });
    std::sort(found.begin(), found.end(), isBefore);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

} // namespace vdblic
