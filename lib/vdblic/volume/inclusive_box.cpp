#include "vdblic/volume/inclusive_box.h"

#include "vdblic/field/vector.h"

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
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

/// The faces of boxes, in groups; the last box fills up its group.
class BoxFaces {
  public:
    explicit BoxFaces(const std::vector<InclusiveBox>& boxes)
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (const bool isHigh : {false, true}) {
                std::vector<float>& faces = mFaces[axis][std::size_t(isHigh)];
                faces.reserve(boxes.size() + kGroup - 1);
                for (const InclusiveBox& box : boxes)
                    faces.push_back(isHigh ? float(box.high[axis]) + 0.5f : float(box.low[axis]) - 0.5f);
                faces.resize((boxes.size() + kGroup - 1) / kGroup * kGroup, faces.back());
            }
        }
    }

    /// The boxes that reach farthest in a direction, by number.
    [[nodiscard]] std::vector<std::size_t> farthest(const glm::dvec3& direction) const;

  private:
    static constexpr std::size_t kGroup = 8 * std::size_t(kLanes);

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
    std::vector<float> most(mFaces[0][0].size() / kGroup);
    for (std::size_t group = 0; group < most.size(); ++group) {
        Float8 lanes = reach(group * kGroup);
        for (std::size_t i = kLanes; i < kGroup; i += kLanes) {
            const Float8 here = reach(group * kGroup + i);
            lanes = here > lanes ? here : lanes;
        }
        most[group] = lanes[0];
        for (int lane = 1; lane < kLanes; ++lane)
            most[group] = std::max(most[group], lanes[lane]);
    }
    const float farthest = *std::max_element(most.begin(), most.end());
    std::vector<std::size_t> found;
    for (std::size_t group = 0; group < most.size(); ++group) {
        if (most[group] < farthest) continue;
        for (std::size_t first = group * kGroup; first < (group + 1) * kGroup; first += kLanes) {
            for (unsigned left = laneBits(reach(first) == farthest); left != 0; left &= left - 1)
                found.push_back(first + std::size_t(std::countr_zero(left)));
        }
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
