#include "vdblic/field/velocity_field.h"

namespace vdblic {

void VelocityField::build(std::shared_ptr<const Domain> domain, const VelocityLevel& start, const VelocityLevel& end)
{
    const Domain& leaves = *domain;
    mBricks.fill(std::move(domain), [&](std::size_t leaf, Record* records) {
        const auto fillLevel = [&](const VelocityLevel& level, int lane) {
            const openvdb::Mat3s toStep(level.toStep);
            visitBrick(level.velocities, leaves.origin(leaf),
                       [&](int record, const openvdb::Vec3f& value, bool active) {
                           float* numbers = records[record].values + lane;
                           const openvdb::Vec3f step = active ? toStep * value : openvdb::Vec3f(0);
                           for (int axis = 0; axis < 3; ++axis)
                               numbers[axis] = step[axis];
                           numbers[3] = active ? 1 : 0;
                       });
        };
        fillLevel(start, 0);
        fillLevel(end, 4);
    });
}

} // namespace vdblic
