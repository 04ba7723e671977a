#include "bench/engine/integrators.h"

#include "bench/engine/advance_all.h"
#include "bench/engine/clock.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/VelocityFields.h>

namespace vdblic::bench {
namespace {

double rate(const Flow& flow, double before, double sink)
{
    const double seconds = cpuTime() - before;
    [[maybe_unused]] volatile const double used = sink; // keeps the compiler from dropping the work
    return 1e-6 * double(flow.frames[0].domain.texture->voxelCount()) / seconds;
}

} // namespace

double ourStepRate(const Flow& flow)
{
    VelocityField field;
    flow.build(0, field);
    PathBatch batch;
    PathlineParams coarse;
    coarse.tolerance = 10; // one step for each seed
    double sink = 0;
    const double before = cpuTime();
    advanceAll(field, coarse, batch, sink);
    return rate(flow, before, sink);
}

double openvdbStepRate(const Flow& flow)
{
    const auto grid = flow.frames[0].values->deepCopy(); // in voxels per step
    for (auto value = grid->beginValueOn(); value; ++value)
        value.setValue(*value * float(flow.step(0).startVelocities().unit.matrix(0, 0)));
    openvdb::tools::VelocityIntegrator<openvdb::Vec3SGrid> integrator(*grid);
    double sink = 0;
    const double before = cpuTime();
    for (auto seed = grid->cbeginValueOn(); seed; ++seed) {
        openvdb::Vec3d p = seed.getCoord().asVec3d();
        integrator.rungeKutta<4>(1.0, p);
        sink += p.x();
    }
    return rate(flow, before, sink);
}

} // namespace vdblic::bench
