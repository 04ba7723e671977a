#include "bench/engine/integrators.h"

#include "bench/engine/advance_all.h"
#include "bench/engine/clock.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/VelocityFields.h>
#if __has_include(<nanovdb/NanoVDB.h>)
#include <nanovdb/util/OpenToNanoVDB.h>
#include <nanovdb/util/SampleFromVoxels.h>
#endif

#include <cstddef>
#include <cstdio>
#include <optional>
#include <vector>

namespace vdblic::bench {
namespace {

using Seeds = std::vector<openvdb::Coord>;

/// Receives a part of every result, which keeps the compiler from dropping the work.
double sink = 0;

Seeds voxelsOf(const Domain& domain)
{
    Seeds seeds;
    for (auto leaf = domain.topology().cbeginLeaf(); leaf; ++leaf) {
        for (auto voxel = leaf->cbeginValueOn(); voxel; ++voxel)
            seeds.push_back(voxel.getCoord());
    }
    return seeds;
}

/// The velocities of frame k in voxels per step.
openvdb::Vec3SGrid::Ptr inVoxelsPerStep(const Flow& flow, std::size_t k)
{
    auto grid = flow.frames[k].values->deepCopy();
    for (auto value = grid->beginValueOn(); value; ++value)
        value.setValue(*value * float(flow.step(k).startVelocities().unit.matrix(0, 0)));
    return grid;
}

/// One classical RK4 step from every seed. @param sample velocity at a position and a time @return processor time [s]
template<typename Vec, typename Real, typename Sample>
double stepAll(const Seeds& seeds, const Sample& sample)
{
    const double before = cpuTime();
    for (const openvdb::Coord& seed : seeds) {
        const Vec p{Real(seed[0]), Real(seed[1]), Real(seed[2])};
        const Vec k1 = sample(p, 0.0f), k2 = sample(p + k1 * Real(0.5), 0.5f), k3 = sample(p + k2 * Real(0.5), 0.5f),
                  k4 = sample(p + k3, 1.0f);
        sink += double((p + (k1 + (k2 + k3) * Real(2) + k4) / Real(6))[0]);
    }
    return cpuTime() - before;
}

double gridSampler(const openvdb::Vec3SGrid& a, const openvdb::Vec3SGrid& b, const Seeds& seeds)
{
    using Accessor = openvdb::Vec3SGrid::ConstAccessor;
    const Accessor accessorA = a.getConstAccessor(), accessorB = b.getConstAccessor();
    const openvdb::tools::GridSampler<Accessor, openvdb::tools::BoxSampler> start(accessorA, a.transform()),
        end(accessorB, b.transform());
    return stepAll<openvdb::Vec3R, double>(seeds, [&](const openvdb::Vec3R& p, float time) {
        const openvdb::Vec3f v = start.isSample(p), w = end.isSample(p);
        return openvdb::Vec3R(v + (w - v) * time);
    });
}

double velocityIntegrator(const openvdb::Vec3SGrid& a, const Seeds& seeds)
{
    openvdb::tools::VelocityIntegrator<openvdb::Vec3SGrid> integrator(a);
    const double before = cpuTime();
    for (const openvdb::Coord& seed : seeds) {
        openvdb::Vec3d p = seed.asVec3d();
        integrator.rungeKutta<4>(1.0, p);
        sink += p.x();
    }
    return cpuTime() - before;
}

#if __has_include(<nanovdb/NanoVDB.h>)
double nanoVdb(const openvdb::Vec3SGrid& a, const openvdb::Vec3SGrid& b, const Seeds& seeds)
{
    const auto first = nanovdb::openToNanoVDB(a), second = nanovdb::openToNanoVDB(b);
    const auto accessorA = first.grid<nanovdb::Vec3f>()->getAccessor(),
               accessorB = second.grid<nanovdb::Vec3f>()->getAccessor();
    const auto start = nanovdb::createSampler<1>(accessorA), end = nanovdb::createSampler<1>(accessorB);
    return stepAll<nanovdb::Vec3f, float>(seeds, [&](const nanovdb::Vec3f& p, float time) {
        const nanovdb::Vec3f v = start(p), w = end(p);
        return v + (w - v) * time;
    });
}
#endif

double ours(const VelocityField& field)
{
    PathBatch batch;
    PathlineParams coarse;
    coarse.tolerance = 10; // one step for each seed
    const double before = cpuTime();
    advanceAll(field, coarse, batch, sink);
    return cpuTime() - before;
}

/// Million RK4 steps a second by VTK on a grid of the same size; nothing where VTK is not installed.
std::optional<double> vtkRate()
{
    std::FILE* const script = ::popen("/usr/bin/python3 -B " VDBLIC_BENCH_FOLDER "/vtk_integrator.py", "r");
    double rate = 0;
    const bool known = script && std::fscanf(script, "%lf", &rate) == 1;
    if (script) ::pclose(script);
    return known ? std::optional(rate) : std::nullopt;
}

} // namespace

nlohmann::json compareIntegrators(const Flow& flow)
{
    const Seeds seeds = voxelsOf(*flow.frames[0].domain.texture);
    nlohmann::json rows;
    double reference = 0;
    const auto report = [&](const char* name, double rate) {
        if (reference == 0) reference = rate;
        std::printf("| %-48s | %6.2f | %5.2f |\n", name, rate, rate / reference);
        rows.push_back({{"name", name}, {"million_steps_per_second", rate}});
    };
    const auto rateOf = [&](double seconds) { return 1e-6 * double(seeds.size()) / seconds; };

    std::printf("\nRK4 steps, 144 x 73 x 81\n\n| | million a second | ratio |\n|---|---|---|\n");
    const auto a = inVoxelsPerStep(flow, 0), b = inVoxelsPerStep(flow, 1);
    report("GridSampler and BoxSampler, two frames", rateOf(gridSampler(*a, *b, seeds)));
    report("OpenVDB's VelocityIntegrator, one frame", rateOf(velocityIntegrator(*a, seeds)));
#if __has_include(<nanovdb/NanoVDB.h>)
    report("NanoVDB, two frames", rateOf(nanoVdb(*a, *b, seeds)));
#endif
    VelocityField field;
    flow.build(0, field);
    report("advancePaths, two frames, error estimate", rateOf(ours(field)));
    if (const std::optional<double> rate = vtkRate()) report("VTK's vtkStreamTracer, one frame", *rate);
    std::printf("(%g)\n", sink);
    return rows;
}

} // namespace vdblic::bench
