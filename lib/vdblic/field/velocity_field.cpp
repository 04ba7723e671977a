#include "vdblic/field/velocity_field.h"

namespace vdblic {

void VelocityField::build(std::shared_ptr<const Domain> domain, const VelocityLevel& start, const VelocityLevel& end)
{
    const Domain& leaves = *domain;
    mBricks.fill(std::move(domain), [&](std::size_t leaf, Record* records) {
        const auto fillLevel = [&](const VelocityLevel& level, int lane) {
            const openvdb::Mat3s m(level.toStep);
            const Float4 x = {m(0, 0), m(1, 0), m(2, 0), 0}, y = {m(0, 1), m(1, 1), m(2, 1), 0},
                         z = {m(0, 2), m(1, 2), m(2, 2), 0}, covered = {0, 0, 0, 1};
            visitBrick(level.velocities, leaves.origin(leaf),
                       [&](int record, const openvdb::Vec3f& value, bool active) {
                           const Float4 step = x * value[0] + y * value[1] + z * value[2] + covered;
                           *reinterpret_cast<Float4*>(records[record].values + lane) = active ? step : Float4{};
                       });
        };
        fillLevel(start, 0);
        fillLevel(end, 4);
    });
}

} // namespace vdblic
