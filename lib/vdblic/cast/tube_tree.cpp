#include "vdblic/cast/tube_tree.h"

#include "vdblic/cast/round_cones.h"

#include <embree3/rtcore.h>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>

namespace vdblic {
namespace {

/// A place of each ray in the order of hits: by distance, then by the cone.
struct Places {
    Float8 distance;
    Int8 cone; // index in TubeTree::cones()
};

VDBLIC_INLINE Int8 areBefore(const Places& a, const Places& b)
{
    return (a.distance < b.distance) | ((a.distance == b.distance) & (a.cone < b.cone));
}

/// A hit of each ray. Where there is none its distance is infinite.
struct Row {
    Places at;
    Float8 alpha;

    VDBLIC_INLINE void replace(Int8 mask, const Row& by)
    {
        at.distance = mask ? by.at.distance : at.distance;
        at.cone = mask ? by.at.cone : at.cone;
        alpha = mask ? by.alpha : alpha;
    }
};

constexpr float kNowhere = std::numeric_limits<float>::infinity();

/// Rays in Embree's tree, and their nearest hits so far, in order.
struct Query {
    RTCIntersectContext context; // first: Embree passes its address
    const TubeTree* tree;
    const TubeTree::Rays* rays;
    Float8 end;                        // of the rays
    int count;                         // of the rows with a hit
    Row rows[TubeTree::kMostHits + 2]; // the first one lies before all hits, the last one is beyond the nearest
};

/// The same cone in each lane.
VDBLIC_INLINE RoundCones coneOf(const Tubes::Point& first, const Tubes::Point& second)
{
    return {{broadcast8(first.x), broadcast8(first.y), broadcast8(first.z)},
            broadcast8(first.radius),
            {broadcast8(second.x), broadcast8(second.y), broadcast8(second.z)},
            broadcast8(second.radius)};
}

/// Where rays enter round cones.
struct Meeting {
    Float8 middle; // distance of the ray's point that is nearest to the cone, from where distant rays keep their digits
    Vector8 near;  // that point
    Entries entries; // seen from there

    VDBLIC_INLINE Meeting(Int8 mask, const RoundCones& cones, const TubeTree::Rays& rays)
        : middle(dot(cones.a + cones.axis * 0.5f - rays.origin, rays.direction)),
          near(rays.origin + rays.direction * middle), entries(enter(mask, cones, near - cones.a, rays.direction))
    {
    }
};

void boundsOf(const RTCBoundsFunctionArguments* arguments)
{
    const auto& [a, b] = static_cast<const TubeTree*>(arguments->geometryUserPtr)->ends()[arguments->primID];
    const glm::vec3 first(a.x, a.y, a.z), second(b.x, b.y, b.z);
    const glm::vec3 low = glm::min(first - a.radius, second - b.radius);
    const glm::vec3 high = glm::max(first + a.radius, second + b.radius);
    *arguments->bounds_o = {low.x, low.y, low.z, 0, high.x, high.y, high.z, 0};
}

/// Keep hits that are among the nearest of their rays. A ray ends at the hit that leaves too little light.
VDBLIC_INLINE void keep(Int8 mask, const Row& hits, Query& query)
{
    constexpr int kMost = TubeTree::kMostHits;
    int at = query.count + 1;
    if (query.count < kMost) query.rows[++query.count].at.distance = broadcast8(kNowhere);
    for (; anyOf(mask); --at) {
        const Row& before = query.rows[at - 1];
        const Int8 isNearer = mask & areBefore(hits.at, before.at);
        query.rows[at].replace(mask, hits);
        query.rows[at].replace(isNearer, before);
        mask = isNearer;
    }
    const Float8 last = query.rows[query.count].at.distance;
    if (!anyOf(last < kNowhere)) --query.count;
    const Float8 least = query.rays->least;
    Float8 left = query.rays->left;
    for (int i = 1; i <= query.count; ++i) {
        const Row& row = query.rows[i];
        const Int8 isLit = left >= least;
        left -= left * (row.at.distance < kNowhere ? row.alpha : Float8{});
        const Int8 isEnd = isLit & ((left < least) | broadcastInt8(-(i == kMost))) & (row.at.distance < query.end);
        query.end = isEnd ? row.at.distance : query.end;
    }
}

/// Whether entries into a cone lie inside its line's next or previous cone, and so inside the tube.
VDBLIC_INLINE Int8 areInner(const Tubes::Cone& cone, const Tubes::Point* ends, const Vector8& places)
{
    Int8 inner{};
    if (cone.hasPrevious) inner |= coneOf(ends[-1], ends[0]).hold(places);
    if (cone.hasNext) inner |= coneOf(ends[1], ends[2]).hold(places);
    return inner;
}

/// Of a cone and the rays that come near it: Embree passes all, or one at a time where it has no packets.
VDBLIC_KERNEL void intersect(const RTCIntersectFunctionNArguments* arguments)
{
    auto& query = *reinterpret_cast<Query*>(arguments->context);
    const TubeTree& tree = *query.tree;
    const TubeTree::Rays& rays = *query.rays;
    const unsigned count = arguments->N, shown = arguments->primID;
    RTCRayN* const ways = RTCRayHitN_RayN(arguments->rayhit, count);
    Int8 mask{};
    if (count == kLanes) {
        std::memcpy(&mask, arguments->valid, sizeof mask);
    } else {
        for (unsigned i = 0; i < count; ++i)
            mask[RTCRayN_id(ways, count, i)] = arguments->valid[i];
    }
    const TubeTree::Ends& body = tree.ends()[shown];
    const Meeting meeting(mask, coneOf(body.first, body.second), rays);
    const Entries& entries = meeting.entries;
    Row hits{{entries.distance + meeting.middle, broadcastInt8(int(shown))}, Float8{}};
    mask = entries.isThere & (hits.at.distance > 0) & (hits.at.distance <= query.end) &
           areBefore({rays.last, rays.lastCone}, hits.at);
    if (!anyOf(mask)) return;
    const Tubes& tubes = tree.tubes();
    const std::uint32_t number = tree.cones()[shown];
    const Tubes::Cone& cone = tubes.cones()[number];
    if (cone.hasPrevious) mask &= entries.share != 0; // the first sphere is the previous cone's
    hits.alpha = tree.alpha(Tubes::valuesAt(tubes.drivers(), cone.first, entries.share),
                            Tubes::valuesAt(tubes.opacities(), cone.first, entries.share),
                            tree.halo(dot(entries.normal, rays.direction)));
    mask &= (hits.alpha > 0) & ~areInner(cone, tubes.points(number), meeting.near + rays.direction * entries.distance);
    if (!anyOf(mask)) return;
    keep(mask, hits, query);
    if (count == kLanes) {
        std::memcpy(&RTCRayN_tfar(ways, count, 0), &query.end, sizeof query.end);
    } else {
        for (unsigned i = 0; i < count; ++i)
            RTCRayN_tfar(ways, count, i) = query.end[RTCRayN_id(ways, count, i)];
    }
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

TubeTree::TubeTree(const Tubes& tubes, const Look& look) : ShownTubes(tubes, look)
{
    if (cones().empty()) return;
    mEnds.reserve(cones().size());
    for (const std::uint32_t number : cones())
        mEnds.push_back({tubes.points(number)[0], tubes.points(number)[1]});
    mScene = std::shared_ptr<RTCSceneTy>(rtcNewScene(device()), [](RTCScene old) { rtcReleaseScene(old); });
    rtcSetSceneFlags(mScene.get(), RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, unsigned(mEnds.size()));
    rtcSetGeometryUserData(geometry, this); // for the bounds, which are computed in this function
    rtcSetGeometryBoundsFunction(geometry, boundsOf, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(mScene.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(mScene.get());
    if (rtcGetDeviceError(device()) != RTC_ERROR_NONE) throw std::bad_alloc();
}

VDBLIC_KERNEL int TubeTree::next(Rays& rays, Hits* hits) const
{
    if (!mScene || !anyOf(rays.isActive)) return 0;
    Query query;
    rtcInitIntersectContext(&query.context);
    query.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    query.tree = this;
    query.rays = &rays;
    query.end = rays.end;
    query.count = 0;
    query.rows[0].at = {broadcast8(-kNowhere), Int8{}};
    RTCRayHit8 ways{};
    std::memcpy(ways.ray.org_x, &rays.origin, sizeof rays.origin);
    std::memcpy(ways.ray.dir_x, &rays.direction, sizeof rays.direction);
    std::memcpy(ways.ray.tnear, &rays.last, sizeof rays.last);
    std::memcpy(ways.ray.tfar, &rays.end, sizeof rays.end);
    for (unsigned lane = 0; lane < kLanes; ++lane) {
        ways.ray.mask[lane] = ~0u;
        ways.ray.id[lane] = lane;
        ways.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(reinterpret_cast<const int*>(&rays.isActive), mScene.get(), &query.context, &ways);
    for (int i = 0; i < query.count; ++i) {
        const Row& row = query.rows[i + 1];
        const Int8 isThere = (row.at.distance < kNowhere) & (rays.left >= rays.least);
        int shown[kLanes];
        storeLanes(isThere ? row.at.cone : Int8{}, shown);
        Float8 points[kLanes];
        Int8 numbers{};
        for (int lane = 0; lane < kLanes; ++lane) {
            std::memcpy(&points[lane], &mEnds[std::size_t(shown[lane])], sizeof points[lane]);
            numbers[lane] = int(cones()[std::size_t(shown[lane])]);
        }
        transpose(points, points);
        const RoundCones bodies({points[0], points[1], points[2]}, points[3], {points[4], points[5], points[6]},
                                points[7]);
        const Entries entries = Meeting(isThere, bodies, rays).entries;
        hits[i] = {.isThere = isThere,
                   .distance = isThere ? row.at.distance : Float8{},
                   .cone = numbers,
                   .share = isThere ? entries.share : Float8{},
                   .alpha = isThere ? row.alpha : Float8{},
                   .normal = select(isThere, entries.normal, Vector8{})};
        rays.left -= rays.left * hits[i].alpha;
        rays.last = isThere ? row.at.distance : rays.last;
        rays.lastCone = isThere ? row.at.cone : rays.lastCone;
    }
    const bool isFull = query.count == kMostHits;
    rays.isActive &= (rays.left >= rays.least) & broadcastInt8(-isFull);
    if (isFull) rays.isActive &= query.rows[kMostHits].at.distance < kNowhere;
    return query.count;
}

} // namespace vdblic
