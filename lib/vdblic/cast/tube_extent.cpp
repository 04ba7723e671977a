#include "vdblic/cast/tube_extent.h"

#include "vdblic/camera/clipping.h"
#include "vdblic/cast/extinction_grid.h"
#include "vdblic/cast/tubes.h"
#include "vdblic/volume/inclusive_box.h"

#include <openvdb/openvdb.h>

#include <algorithm>

namespace vdblic {

std::vector<glm::dvec3> visibleExtent(const Tubes& tubes, const ExtinctionGrid& visible, const ClipParams& clip)
{
    if (tubes.empty()) return {};
    constexpr float kLeastShare = 0.05f; // of the largest extinction
    const std::vector<ClipPlane> planes = clip.allPlanes();
    const float most = *std::max_element(visible.values().begin(), visible.values().end());
    if (!(most > 0)) return {};
    std::vector<InclusiveBox> cells;
    const openvdb::CoordBBox all(openvdb::Coord(0), visible.dim() - openvdb::Coord(1));
    for (auto cell = all.begin(); cell; ++cell) {
        if (!(visible.values()[visible.index(*cell)] > kLeastShare * most)) continue;
        InclusiveBox box{};
        for (int axis = 0; axis < 3; ++axis) {
            box.low[std::size_t(axis)] = visible.origin()[axis] + (*cell)[axis] * visible.cell();
            box.high[std::size_t(axis)] = box.low[std::size_t(axis)] + visible.cell() - 1;
        }
        if (!isCutAway(box.corners(tubes.indexToWorld()), planes)) cells.push_back(box);
    }
    std::vector<glm::dvec3> points;
    for (const InclusiveBox& cell : outermost(cells, tubes.high() - tubes.low())) {
        const auto corners = cell.corners(tubes.indexToWorld());
        points.insert(points.end(), corners.begin(), corners.end());
    }
    return points;
}

} // namespace vdblic
