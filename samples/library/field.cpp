// Computes the texture of a velocity in memory. A VelocityFrame holds the velocity and the voxels to compute on; a
// FlowStep leads from one frame to the next, here to the same one, because the flow is steady. Each further step gives
// the next texture of the sequence.
#include <vdblic/field/box_domain.h>
#include <vdblic/methods/registry.h>

#include <openvdb/openvdb.h>

#include <iostream>

int main()
{
    openvdb::initialize();
    const auto domain = vdblic::boxDomain({48, 48, 16});
    const auto velocity = openvdb::Vec3SGrid::create();
    velocity->tree().topologyUnion(domain->topology());
    for (auto value = velocity->beginValueOn(); value; ++value) { // a vortex, in world units per second
        const openvdb::Vec3d at = value.getCoord().asVec3d() - openvdb::Vec3d(24, 24, 0);
        value.setValue(openvdb::Vec3f(float(-0.1 * at.y()), float(0.1 * at.x()), 0.2f));
    }

    const vdblic::VelocityFrame frame(domain, velocity);
    const vdblic::FlowStep step{frame, frame, /*interval=*/1};
    const auto textures = vdblic::makeFlowTexture({.texture = {.lifeSpan = 4}}, {vdblic::NoiseField(/*seed=*/1)});
    vdblic::TextureFrame made;
    for (int i = 0; i < 8; ++i) // the first ones are still short of streaks
        made = textures->advance(step);

    const auto grid = openvdb::FloatGrid::create(made.texture.tree());
    grid->setName("density");
    openvdb::io::File("field.vdb").write({grid});
    std::cout << grid->activeVoxelCount() << " voxels\n";
}
