#include "vdblic/cast/tube_tree.h"

#include "vdblic/cast/lanes.h"

#include <embree3/rtcore.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <optional>

namespace vdblic {
namespace {

using Vec3 = glm::vec3;

Vec3 placeOf(const Tubes::Point& point)
{
    return {point.x, point.y, point.z};
}

/// The hull of two spheres.
struct RoundCone {
    Vec3 a, axis;         // centre of the first sphere, and the vector to the second one's
    float radius, shrink; // of the first sphere; by how much the second one is smaller
    float square;         // of the axis' length

    RoundCone(const Tubes::Point& first, const Tubes::Point& second)
        : a(placeOf(first)), axis(placeOf(second) - a), radius(first.radius), shrink(first.radius - second.radius),
          square(glm::dot(axis, axis))
    {
    }

    /// Whether a point lies well inside.
    [[nodiscard]] bool holds(const Vec3& point) const
    {
        constexpr float kWell = 0.999f;
        const Vec3 from = point - a;
        const float along = square > 0 ? std::clamp(glm::dot(from, axis) / square, 0.0f, 1.0f) : 0;
        const Vec3 aside = from - axis * along;
        const float reach = kWell * (radius - shrink * along);
        return glm::dot(aside, aside) < reach * reach;
    }
};

/// Where a ray enters something.
struct Entry {
    float distance, share;
    Vec3 normal;
};

/// @param from of the sphere's centre to the ray's origin  @param direction of length 1
std::optional<float> enterSphere(const Vec3& from, const Vec3& direction, float radius)
{
    const float middle = -glm::dot(from, direction);
    const Vec3 aside = from + direction * middle;
    const float rest = radius * radius - glm::dot(aside, aside);
    if (!(rest > 0)) return std::nullopt;
    return middle - std::sqrt(rest);
}

/// Where a line enters a round cone: its mantle, or one of its spheres. The mantle touches the spheres and holds them,
/// so a line that misses it misses all (the quadratic equation as Quilez has it, "Rounded cone", 2018).
/// @param from from the first sphere's centre to the ray's origin
std::optional<Entry> enter(const RoundCone& cone, const Vec3& from, const Vec3& direction)
{
    const float square = cone.square - cone.shrink * cone.shrink;
    if (square > 0) {
        const float along = glm::dot(direction, cone.axis), start = glm::dot(from, cone.axis);
        const float a = square - along * along;
        const float b = square * glm::dot(from, direction) - start * along + along * cone.shrink * cone.radius;
        const float c = square * glm::dot(from, from) - start * start + 2 * start * cone.shrink * cone.radius -
                        cone.square * cone.radius * cone.radius;
        const float discriminant = b * b - a * c;
        if (!(discriminant >= 0)) return std::nullopt;
        constexpr float kParallel = 1e-6f;
        if (std::abs(a) > kParallel * square) {
            const float distance = (-b - std::sqrt(discriminant)) / a;
            const float height = start - cone.radius * cone.shrink + distance * along;
            if (height >= 0 && height <= square) {
                const Vec3 outward = (from + direction * distance) * square - cone.axis * height;
                return Entry{distance, height / square, glm::normalize(outward)};
            }
        }
    }
    std::optional<Entry> best;
    const auto meet = [&](const Vec3& fromCentre, float radius, float share) {
        const std::optional<float> distance = enterSphere(fromCentre, direction, radius);
        if (!distance || (best && best->distance <= *distance)) return;
        best = Entry{*distance, share, (fromCentre + direction * *distance) / radius};
    };
    meet(from, cone.radius, 0);
    meet(from - cone.axis, cone.radius - cone.shrink, 1);
    return best;
}

/// A ray in Embree's tree, and its hits so far.
struct Query {
    RTCIntersectContext context; // first: Embree passes its address
    const TubeTree* tree;
    const TubeTree::Hit* after;
    TubeTree::Hit* hits;
    float left, least;
    int count;
};

bool isBefore(const TubeTree::Hit& a, const TubeTree::Hit& b)
{
    return a.distance != b.distance ? a.distance < b.distance : a.cone < b.cone;
}

void boundsOf(const RTCBoundsFunctionArguments* arguments)
{
    const auto& tree = *static_cast<const TubeTree*>(arguments->geometryUserPtr);
    const Tubes::Point* const ends = tree.tubes().points(tree.cones()[arguments->primID]);
    const Vec3 first = placeOf(ends[0]), second = placeOf(ends[1]);
    const Vec3 low = glm::min(first - ends[0].radius, second - ends[1].radius);
    const Vec3 high = glm::max(first + ends[0].radius, second + ends[1].radius);
    *arguments->bounds_o = {low.x, low.y, low.z, 0, high.x, high.y, high.z, 0};
}

/// Whether an entry into a cone lies inside of its line's next or previous cone, and so inside of the tube.
bool isInner(const Tubes::Cone& cone, const Tubes::Point* ends, const Vec3& place)
{
    return (cone.hasPrevious && RoundCone(ends[-1], ends[0]).holds(place)) ||
           (cone.hasNext && RoundCone(ends[1], ends[2]).holds(place));
}

/// Keep a hit if it is among the nearest. The ray ends at the hit that leaves too little light, and
/// hits beyond it are dropped.
void keep(const TubeTree::Hit& hit, Query& query, float& end)
{
    int at = query.count;
    while (at > 0 && isBefore(hit, query.hits[at - 1]))
        --at;
    if (at == TubeTree::kMostHits) return;
    const int kept = std::min(query.count, TubeTree::kMostHits - 1);
    std::copy_backward(query.hits + at, query.hits + kept, query.hits + kept + 1);
    query.hits[at] = hit;
    query.count = kept + 1;
    float left = query.left;
    for (int i = 0; i < query.count; ++i) {
        left -= left * query.hits[i].alpha;
        if (left < query.least) query.count = i + 1;
    }
    if (query.count == TubeTree::kMostHits || left < query.least) end = query.hits[query.count - 1].distance;
}

void intersect(const RTCIntersectFunctionNArguments* arguments)
{
    if (arguments->valid[0] == 0) return;
    RTCRay& ray = reinterpret_cast<RTCRayHit*>(arguments->rayhit)->ray;
    auto& query = *reinterpret_cast<Query*>(arguments->context);
    const Tubes& tubes = query.tree->tubes();
    const std::uint32_t number = query.tree->cones()[arguments->primID];
    const Tubes::Cone& cone = tubes.cones()[number];
    const Tubes::Point* const ends = tubes.points(number);
    const RoundCone body(ends[0], ends[1]);
    const Vec3 origin(ray.org_x, ray.org_y, ray.org_z), direction(ray.dir_x, ray.dir_y, ray.dir_z);
    // From the point of the ray that is nearest to the cone, so that distant rays keep their digits.
    const float middle = glm::dot(body.a + body.axis * 0.5f - origin, direction);
    const Vec3 near = origin + direction * middle;
    const std::optional<Entry> entry = enter(body, near - body.a, direction);
    if (!entry || (cone.hasPrevious && entry->share == 0)) return; // the first sphere is the previous cone's
    TubeTree::Hit hit{
        entry->distance + middle, number, entry->share, 0, {entry->normal.x, entry->normal.y, entry->normal.z}};
    if (!(hit.distance > 0) || hit.distance > ray.tfar || (query.after && !isBefore(*query.after, hit))) return;
    hit.alpha = query.tree->alpha(Tubes::valueAt(tubes.drivers(), cone.first, hit.share),
                                  Tubes::valueAt(tubes.opacities(), cone.first, hit.share));
    if (!(hit.alpha > 0) || isInner(cone, ends, near + direction * entry->distance)) return;
    keep(hit, query, ray.tfar);
}

/// Of the process. Scenes hold it, too.
RTCDevice device()
{
    constexpr const char* kNoCache = "tessellation_cache_size=0"; // for subdivision surfaces; else 128 MiB
    static const std::shared_ptr<RTCDeviceTy> made(rtcNewDevice(kNoCache),
                                                   [](RTCDevice old) { rtcReleaseDevice(old); });
    if (!made) throw std::bad_alloc(); // every processor meets Embree's other needs
    return made.get();
}

} // namespace

TubeTree::TubeTree(const Tubes& tubes, const Look& look)
    : mTubes(tubes), mTransfer(look.transfer), mTexture(look.texture)
{
    for (std::uint32_t number = 0; number < tubes.cones().size(); ++number) {
        const std::uint32_t first = tubes.cones()[number].first;
        const float a = Tubes::valueAt(tubes.drivers(), first, 0), b = Tubes::valueAt(tubes.drivers(), first, 1);
        const bool isOpaque = tubes.opacities()[first] > 0 || tubes.opacities()[first + 1] > 0;
        if (isOpaque && mTransfer.contributes(std::min(a, b), std::max(a, b))) mCones.push_back(number);
    }
    if (mCones.empty()) return;
    mScene = std::shared_ptr<RTCSceneTy>(rtcNewScene(device()), [](RTCScene old) { rtcReleaseScene(old); });
    rtcSetSceneFlags(mScene.get(), RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, unsigned(mCones.size()));
    rtcSetGeometryUserData(geometry, this); // for the bounds, which are computed in this function
    rtcSetGeometryBoundsFunction(geometry, boundsOf, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(mScene.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(mScene.get());
    if (rtcGetDeviceError(device()) != RTC_ERROR_NONE) throw std::bad_alloc();
}

float TubeTree::alpha(float driver, float opacity) const
{
    const Float8 density = mTexture.density(mTexture.stretched(broadcast8(opacity)));
    const float extinction = mTransfer.extinctions()[mTransfer.entries(broadcast8(driver))[0]];
    return 1 - powerOfTwo(-std::numbers::log2e_v<float> * extinction * density)[0];
}

int TubeTree::nearest(const Ray& ray, const Hit* after, float left, Hit* hits) const
{
    if (!mScene) return 0;
    Query query{{}, this, after, hits, left, ray.leastTransmittance, 0};
    rtcInitIntersectContext(&query.context);
    RTCRayHit way{};
    RTCRay& line = way.ray;
    line.org_x = ray.origin[0];
    line.org_y = ray.origin[1];
    line.org_z = ray.origin[2];
    line.dir_x = ray.direction[0];
    line.dir_y = ray.direction[1];
    line.dir_z = ray.direction[2];
    line.tnear = after ? after->distance : 0;
    line.tfar = ray.end;
    line.mask = ~0u;
    way.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(mScene.get(), &query.context, &way);
    return query.count;
}

} // namespace vdblic
