#include "vdblic/run/line_output.h"

#include "vdblic/core/message.h"
#include "vdblic/lines/line_grid.h"
#include "vdblic/methods/flow_texture.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

namespace vdblic {
namespace {

/// Give the writer's lines the scalars at their points, which all ranks know. Collective.
void takeFromOwners(Exchange& exchange, int writer, const VelocityFrame& frame,
                    std::span<const openvdb::FloatGrid::Ptr> scalars, Lines& lines)
{
    std::vector<std::vector<std::uint32_t>> owned(std::size_t(exchange.size())); // points, by rank
    for (std::uint32_t point = 0; point < lines.pointCount(); ++point) {
        const int owner = frame.partition->owner({openvdb::Coord::round(lines.positions[point])});
        owned[std::size_t(owner)].push_back(point);
    }
    std::vector<openvdb::Vec3f> places;
    for (const std::uint32_t point : owned[std::size_t(exchange.rank())])
        places.push_back(lines.positions[point]);
    std::vector<Exchange::Bytes> messages(owned.size());
    for (const openvdb::FloatGrid::Ptr& scalar : scalars)
        put(messages[std::size_t(writer)], valuesAt(*scalar, places, frame.values->transform()).data(), places.size());
    messages = exchange.swap(std::move(messages));
    if (exchange.rank() != writer) return;
    for (const openvdb::FloatGrid::Ptr& scalar : scalars)
        lines.scalars.push_back({scalar->getName(), std::vector<float>(lines.pointCount())});
    for (std::size_t rank = 0; rank < owned.size(); ++rank) {
        MessageReader message(messages[rank]);
        for (Lines::Scalar& scalar : lines.scalars) {
            for (const std::uint32_t point : owned[rank])
                scalar.values[point] = message.get<float>();
        }
    }
}

} // namespace

openvdb::GridBase::Ptr lineOutput(Exchange& exchange, int writer, std::vector<openvdb::FloatGrid::Ptr> scalars,
                                  TextureFrame& made)
{
    Lines lines = *std::exchange(made.lines, std::nullopt);
    if (!exchange.isAlone()) {
        takeFromOwners(exchange, writer, made.frame, scalars, lines);
        if (exchange.rank() != writer) return nullptr;
        scalars.clear();
    }
    for (const openvdb::GridBase::Ptr& grid : made.frame.carried) {
        if (const auto scalar = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) scalars.push_back(scalar);
    }
    return lineGrid(lines, made.frame.values->transform(), scalars);
}

} // namespace vdblic
