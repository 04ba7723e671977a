#include "vdblic/render/annotated_box.h"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

namespace vdblic {
namespace {

/// An edge of a box and the sides of its two faces.
struct BoxEdge {
    int axis;             // that the edge runs along
    std::size_t from, to; // corners
    bool facing[2];       // whether its faces are seen from outside
};

/// A corner in the picture [pixels]; nullopt behind the eye.
std::optional<glm::dvec2> seen(const glm::dvec3& point, const Camera& camera)
{
    const glm::dvec4 ndc = camera.worldToNdc() * glm::dvec4(point, 1);
    if (!(ndc.w > 0)) return std::nullopt;
    return glm::dvec2(ndc) / ndc.w * glm::dvec2(camera.size());
}

/// Whether the eye is in front of a face of the box. @param side 0 or 1 along the axis
bool isFacing(const Corners& box, std::size_t axis, std::size_t side, const Camera& camera)
{
    const auto edge = [&](std::size_t a) { return box[std::size_t(1) << a] - box[0]; };
    glm::dvec3 outward = glm::cross(edge((axis + 1) % 3), edge((axis + 2) % 3));
    if ((glm::dot(outward, edge(axis)) > 0) != (side == 1)) outward = -outward;
    const bool perspective = camera.projection() == Projection::kPerspective;
    const glm::dvec3 towardsEye = perspective ? camera.eye() - box[side << axis] : camera.eye() - camera.target();
    return glm::dot(outward, towardsEye) > 0;
}

std::vector<BoxEdge> edgesOf(const Corners& box, const Camera& camera)
{
    std::vector<BoxEdge> edges;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
        for (std::size_t side = 0; side < 4; ++side) {
            const std::size_t from = (side & 1) << b | (side >> 1) << c;
            edges.push_back({int(axis),
                             from,
                             from | std::size_t(1) << axis,
                             {isFacing(box, b, side & 1, camera), isFacing(box, c, side >> 1, camera)}});
        }
    }
    return edges;
}

/// The axis of a box that is most upright in space.
int uprightAxis(const Corners& box, const glm::dvec3& up)
{
    int best = 0;
    double most = -1;
    for (int axis = 0; axis < 3; ++axis) {
        const double share = std::abs(glm::dot(glm::normalize(box[std::size_t(1) << axis] - box[0]), up));
        if (share <= most) continue;
        most = share;
        best = axis;
    }
    return best;
}

/// Of the edges along an axis that are on the outline, the lowest in the picture, or the leftmost of upright ones.
std::optional<BoxEdge> edgeForTicks(const std::vector<BoxEdge>& edges, int axis, const Corners& box,
                                    const Camera& camera)
{
    std::optional<BoxEdge> best;
    double bestPlace = 0;
    for (const BoxEdge& edge : edges) {
        if (edge.axis != axis || edge.facing[0] == edge.facing[1]) continue;
        const auto from = seen(box[edge.from], camera), to = seen(box[edge.to], camera);
        if (!from || !to) continue;
        const double place = axis == uprightAxis(box, camera.up()) ? from->x + to->x : -(from->y + to->y);
        if (best && place >= bestPlace) continue;
        best = edge;
        bestPlace = place;
    }
    return best;
}

/// The world's axis that an edge runs along; −1: none.
int worldAxis(const glm::dvec3& along)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(along[axis]) > 0.999999 * glm::length(along)) return axis;
    }
    return -1;
}

} // namespace

std::vector<Tick> ticks(const ScalarAxis& axis, int wanted)
{
    const auto [low, high] = axis.range;
    std::vector<Tick> result;
    const double decades = axis.scale == ValueScale::kLogarithmic ? std::log10(high / low) : 0;
    if (decades < 1) {
        double step = 0;
        for (const double value : roundNumbers(low, high, wanted, step))
            result.push_back({value, tickText(value, step)});
        return result;
    }
    const int every = int(std::ceil(decades / wanted)); // powers
    for (int power = int(std::floor(std::log10(low))); power <= std::log10(high) + 1e-9; ++power) {
        if (power % every != 0) continue;
        for (const double factor : {1.0, 2.0, 5.0}) {
            const double value = factor * std::pow(10, power);
            if (factor > 1 && 3 * decades > 1.5 * wanted) continue;
            if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9))
                result.push_back({value, fmt::format("{:.3g}", value)});
        }
    }
    return result;
}

void drawBox(const CairoCanvas& canvas, const Corners& box, const Camera& camera, bool far)
{
    for (const BoxEdge& edge : edgesOf(box, camera)) {
        if ((!edge.facing[0] && !edge.facing[1]) != far) continue;
        const auto from = seen(box[edge.from], camera), to = seen(box[edge.to], camera);
        if (from && to) canvas.drawLine(*from, *to);
    }
}

namespace {

/// The edge that an axis is drawn along, in the picture [pixels].
struct AxisEdge {
    glm::dvec3 from, along; // in the picture's world
    glm::dvec2 begin, end, outward;
    double low, high; // coordinates at its ends, or distances if the box is turned
    int world;        // axis; −1: the box is turned
};

std::optional<AxisEdge> axisEdge(const std::vector<BoxEdge>& edges, int axis, const Corners& box,
                                 const glm::dvec3& stretch, const Camera& camera, const glm::dvec2& middle)
{
    const std::optional<BoxEdge> edge = edgeForTicks(edges, axis, box, camera);
    if (!edge) return std::nullopt;
    const glm::dvec3 from = box[edge->from], along = box[edge->to] - from;
    const glm::dvec2 begin = *seen(from, camera), end = *seen(from + along, camera);
    glm::dvec2 outward(begin.y - end.y, end.x - begin.x);
    if (!(glm::length(outward) > 0)) return std::nullopt;
    outward = glm::normalize(outward);
    if (glm::dot((begin + end) / 2.0 - middle, outward) < 0) outward = -outward;
    const int world = worldAxis(along);
    const double low = world < 0 ? 0 : from[world] / stretch[world];
    const double high = world < 0 ? glm::length(along / stretch) : (from[world] + along[world]) / stretch[world];
    return AxisEdge{from, along, begin, end, outward, low, high, world};
}

/// The middle of a text beside a point, at a distance from it to the text's border.
glm::dvec2 besidePoint(const glm::dvec2& point, const glm::dvec2& outward, double distance, const glm::dvec2& extent)
{
    return point + outward * (distance + (std::abs(outward.x) * extent.x + std::abs(outward.y) * extent.y) / 2);
}

} // namespace

void drawAxes(const CairoCanvas& canvas, Labels& labels, const Corners& box, const glm::dvec3& stretch,
              const std::string& lengthUnit, const Camera& camera, double textSize)
{
    constexpr int kMostTicks = 5;
    const double gap = 0.6 * textSize;
    const auto middle = seen(middleOf(box), camera);
    if (!middle) return;
    const std::vector<BoxEdge> all = edgesOf(box, camera);
    std::vector<AxisEdge> edges;
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const std::optional<AxisEdge> edge = axisEdge(all, axis, box, stretch, camera, *middle);
        // A very short edge, such as of a layer of voxels, needs no numbers.
        if (!edge || glm::length(edge->end - edge->begin) < 2 * textSize) continue;
        edges.push_back(*edge);
        largest = std::max({largest, std::abs(edge->low), std::abs(edge->high)});
    }
    const AxisUnit unit = axisUnit(largest, lengthUnit);
    for (const AxisEdge& edge : edges) {
        const auto [lowest, highest] = std::minmax(edge.low, edge.high);
        double widest = 0; // of the numbers, across the edge
        for (int wanted = kMostTicks; wanted > 0; --wanted) {
            double step = 0;
            std::vector<Label> numbers;
            std::vector<glm::dvec2> points;
            for (const double value : roundNumbers(lowest / unit.factor, highest / unit.factor, wanted, step)) {
                const double share = (value * unit.factor - edge.low) / (edge.high - edge.low);
                const auto point = seen(edge.from + edge.along * share, camera);
                if (!point) continue;
                const std::string text = tickText(value, step);
                const glm::dvec2 extent = labels.extent(text);
                points.push_back(*point);
                numbers.push_back({text, besidePoint(*point, edge.outward, gap, extent)});
                widest = std::max(widest, glm::dot(glm::abs(edge.outward), extent));
            }
            if (!labels.write(numbers)) continue;
            for (const glm::dvec2& point : points)
                canvas.drawLine(point, point + edge.outward * 0.4 * textSize);
            break;
        }
        if (edge.world < 0) continue;
        const std::string title = scalarTitle(std::string(1, "xyz"[edge.world]), unit.text);
        const glm::dvec2 extent = labels.extent(title), along = glm::normalize(edge.end - edge.begin);
        const auto beside = [&](double share) {
            return Label{title,
                         besidePoint(glm::mix(edge.begin, edge.end, share), edge.outward, 2 * gap + widest, extent)};
        };
        // Without room beside the numbers, an end of the edge may have it.
        const auto beyond = [&](const glm::dvec2& end, const glm::dvec2& direction) {
            return Label{title, besidePoint(end + edge.outward * gap, direction, gap, extent)};
        };
        for (const Label& label :
             {beside(0.5), beside(0.75), beside(0.25), beyond(edge.end, along), beyond(edge.begin, -along)}) {
            std::vector<Label> one{label};
            if (labels.write(one)) break;
        }
    }
}

glm::dvec2 Labels::extent(const std::string& text) const
{
    cairo_text_extents_t extents;
    cairo_text_extents(mCanvas.context(), text.c_str(), &extents);
    return {extents.x_advance, mTextSize};
}

LabelArea Labels::areaOf(const Label& label) const
{
    const glm::dvec2 half = extent(label.text) / 2.0 + 0.15 * mTextSize;
    return {label.middle - half, label.middle + half};
}

bool Labels::write(std::vector<Label>& labels)
{
    std::vector<LabelArea> areas;
    const auto isIn = [](const std::vector<LabelArea>& taken, const LabelArea& area) {
        return std::any_of(taken.begin(), taken.end(), [&](const LabelArea& other) { return area.overlaps(other); });
    };
    for (const Label& label : labels) {
        if (isIn(areas, areaOf(label))) return false;
        areas.push_back(areaOf(label));
    }
    std::vector<Label> kept;
    std::copy_if(labels.begin(), labels.end(), std::back_inserter(kept),
                 [&](const Label& label) { return areaOf(label).isInside(mSize) && !isIn(mTaken, areaOf(label)); });
    if (kept.empty() || 2 * kept.size() < labels.size()) return false;
    labels = std::move(kept);
    for (const Label& label : labels) {
        mCanvas.drawText(label.middle + glm::dvec2(0, 0.36 * mTextSize), 0.5, label.text);
        mTaken.push_back(areaOf(label));
    }
    return true;
}

} // namespace vdblic
