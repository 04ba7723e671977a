/// The engine's benchmark: what each method costs and gives, how time grows with life span, size and sparsity, and the
/// integrator against OpenVDB's own. Everything in one run on one thread unless it says otherwise, so that ratios hold
/// where absolute times do not.
///
///     engine [--frames N] [--velocity PATTERN RANGE] [--json FILE]

#include "bench/euler_uflic.h"
#include "bench/scap_auflic.h"
#include "vdblic/field/synth.h"
#include "vdblic/lic/coherence.h"
#include "vdblic/lic/flow_sequence.h"
#include "vdblic/lic/flow_texture.h"

#include <nlohmann/json.hpp>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/VelocityFields.h>
#if __has_include(<nanovdb/NanoVDB.h>)
#include <nanovdb/util/OpenToNanoVDB.h>
#include <nanovdb/util/SampleFromVoxels.h>
#endif
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

using namespace vdblic;
using nlohmann::json;

/// A flow held in memory, in voxels per step.
struct Flow {
    std::vector<FlowFrame> frames;
    std::vector<openvdb::Mat3d> toStep;

    [[nodiscard]] std::size_t steps() const { return frames.size() - 1; }
    [[nodiscard]] FlowStep step(std::size_t k) const
    {
        return {frames[k], frames[k + 1], toStep[k], toStep[k + 1], 1.0};
    }
    void build(std::size_t k, VelocityField& field) const
    {
        field.build(frames[k].domain, {frames[k].velocities->tree(), toStep[k]},
                    {frames[k + 1].velocities->tree(), toStep[k + 1]});
    }
};

Flow analytic(const BoxSize& size, int frames, const std::shared_ptr<const Domain>& domain)
{
    constexpr double kDt = 1.0 / 24;
    const FlowFunction function = flowInBox(findAnalyticFlow("abc"), size, 1.0);
    const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
    Flow flow;
    for (int k = 0; k < frames; ++k) {
        flow.frames.push_back({domain, sampleFlow(function, *domain, *transform, k * kDt), openvdb::Mat3d::identity()});
        flow.toStep.push_back(openvdb::Mat3d::identity() * kDt);
    }
    return flow;
}

Flow fromFiles(const std::string& pattern, const std::string& range)
{
    FlowSequenceParams params;
    params.input.pattern = pattern;
    params.input.frames = range;
    Reporter silent;
    FlowSequence sequence(params, std::cin, silent);
    Flow flow;
    std::optional<LoadedFrame> frame = sequence.next();
    while (frame) {
        std::optional<LoadedFrame> next = sequence.next();
        const double seconds = sequence.intervalAfter(*frame, next ? &*next : nullptr).seconds;
        flow.toStep.push_back(frame->velocity.toVoxelsPerStep(seconds));
        flow.frames.push_back(std::move(frame->flow));
        frame = std::move(next);
    }
    return flow;
}

/// Seconds of this process's CPU time, of all its threads.
double cpuTime()
{
    return double(std::clock()) / CLOCKS_PER_SEC;
}
double wallTime()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// What a run of a method cost and gave, per voxel and frame.
struct Figures {
    double nanoseconds = 0, wallNanoseconds = 0;
    StageTimes times; // seconds in all
    ScatterStats stats;
    double voxels = 0;
    std::vector<double> temporal, smoothed, along, deviation;
};

double mean(const std::vector<double>& values)
{
    double sum = 0;
    for (const double value : values)
        sum += value;
    return values.empty() ? std::nan("") : sum / double(values.size());
}

/// Adds the coherence of textures that follow each other.
class CoherenceMeter {
  public:
    void add(const Flow& flow, std::size_t k, const LeafValues<float>& texture, Figures& figures)
    {
        SmoothedTexture current(*texture.tree());
        if (mLast) {
            CoherenceParams params;
            params.samples = 30'000;
            VelocityField field;
            flow.build(k - 1, field);
            const FrameCoherence c = measureCoherence(*mLast, &current, field, params, std::int64_t(k));
            figures.temporal.push_back(c.raw.temporal);
            figures.smoothed.push_back(c.smoothed.temporal);
            figures.along.push_back(c.raw.alongLength);
            figures.deviation.push_back(c.raw.deviation);
        }
        mLast.emplace(std::move(current));
    }

  private:
    std::optional<SmoothedTexture> mLast;
};

/// @param measured the last steps, of which coherence is taken; the first fill the life span and are left out
Figures run(const Flow& flow, const ScatterParams& scatter, bool coherence)
{
    FlowTexture pipeline(scatter, FeedbackParams{}, NoiseField(1));
    Figures figures;
    CoherenceMeter meter;
    for (int i = 0; i < scatter.lifeSpan; ++i)
        (void)pipeline.advance({flow.frames[0], flow.frames[0], flow.toStep[0], flow.toStep[0], 1.0});
    double cpu = 0, wall = 0;
    for (std::size_t k = 0; k < flow.steps(); ++k) {
        const double cpuBefore = cpuTime(), wallBefore = wallTime();
        const FlowTextureStep result = pipeline.advance(flow.step(k));
        cpu += cpuTime() - cpuBefore;
        wall += wallTime() - wallBefore;
        figures.times += result.times;
        figures.stats += result.stats;
        figures.voxels += double(flow.frames[k].domain->voxelCount());
        if (coherence) meter.add(flow, k, result.texture, figures);
    }
    figures.nanoseconds = 1e9 * cpu / figures.voxels;
    figures.wallNanoseconds = 1e9 * wall / figures.voxels;
    return figures;
}

/// A method in the order of scattering processes, which needs the velocities of a life span ahead.
template<typename Method>
Figures runProcesses(const Flow& flow, int lifeSpan, Method&& method)
{
    Figures figures;
    CoherenceMeter meter;
    double cpu = 0;
    std::vector<VelocityField> fields(flow.steps() + std::size_t(lifeSpan));
    for (std::size_t k = 0; k < fields.size(); ++k)
        flow.build(std::min(k, flow.steps() - 1), fields[k]);
    for (std::size_t k = 0; k < flow.steps(); ++k) {
        const double before = cpuTime();
        const LeafValues<float> texture = method.scatteringProcess(k, fields);
        if (k < std::size_t(lifeSpan)) continue; // the buckets fill
        cpu += cpuTime() - before;
        figures.voxels += double(flow.frames[k].domain->voxelCount());
        figures.stats += method.stats();
        meter.add(flow, k, texture, figures);
    }
    figures.nanoseconds = 1e9 * cpu / figures.voxels;
    return figures;
}

json row(const std::string& name, const Figures& f)
{
    const auto per = [&](double amount) { return amount / f.voxels; };
    const auto live = double(f.stats.particles + f.stats.released);
    std::printf("| %-34s | %7.1f | %5.1f | %5.1f | %5.1f | %5.1f | %5.2f | %5.2f | %6.2f | %5.1f | %.2f | %.3f / %.3f "
                "| %4.1f | %.3f |\n",
                name.c_str(), f.nanoseconds, 1e9 * per(f.times.load), 1e9 * per(f.times.scatter),
                1e9 * per(f.times.convolve), 1e9 * per(f.times.filter), per(live), per(double(f.stats.steps)),
                per(double(f.stats.deposits)), per(double(f.stats.hits)), 100 * per(double(f.stats.emptyVoxels)),
                mean(f.temporal), mean(f.smoothed), mean(f.along), mean(f.deviation));
    std::fflush(stdout);
    return {{"name", name},
            {"ns_per_voxel", f.nanoseconds},
            {"wall_ns_per_voxel", f.wallNanoseconds},
            {"seconds",
             {{"load", f.times.load},
              {"scatter", f.times.scatter},
              {"convolve", f.times.convolve},
              {"filter", f.times.filter}}},
            {"live_per_voxel", per(live)},
            {"steps_per_voxel", per(double(f.stats.steps))},
            {"deposits_per_voxel", per(double(f.stats.deposits))},
            {"hits_per_voxel", per(double(f.stats.hits))},
            {"zero_hit_share", per(double(f.stats.emptyVoxels))},
            {"temporal", mean(f.temporal)},
            {"temporal_smoothed", mean(f.smoothed)},
            {"along_length", mean(f.along)},
            {"deviation", mean(f.deviation)}};
}

void header(const char* title)
{
    std::printf(
        "\n%s\n\n| | ns per voxel and frame | load | scatter | convolve | filter | live | steps | deposits | hits "
        "| zero hits [%%] | temporal raw / smoothed | along | deviation "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        title);
}

ScatterParams scatterParams(ScatterMethod method, int lifeSpan, float window, bool history)
{
    ScatterParams params;
    params.method = method;
    params.lifeSpan = lifeSpan;
    params.releaseWindow = window;
    params.history = history;
    return params;
}

json methods(const Flow& flow, const char* title)
{
    header(title);
    const auto auflic = [](float window, bool history) {
        return scatterParams(ScatterMethod::kAuflic, 4, window, history);
    };
    json rows;
    rows.push_back(row("UFLIC as in the paper, Euler", runProcesses(flow, 4, bench::EulerUflic(4, NoiseField(1)))));
    rows.push_back(row("UFLIC", run(flow, scatterParams(ScatterMethod::kUflic, 4, 1, false), true)));
    rows.push_back(
        row("AUFLIC as in the paper, window 0.25", runProcesses(flow, 4, bench::ScapAuflic(4, 0.25f, NoiseField(1)))));
    for (const float window : {0.125f, 0.25f, 0.5f}) {
        char name[80];
        std::snprintf(name, sizeof name, "AUFLIC, window %g, coasting", double(window));
        rows.push_back(row(name, run(flow, auflic(window, false), true)));
        std::snprintf(name, sizeof name, "AUFLIC, window %g, history", double(window));
        rows.push_back(row(name, run(flow, auflic(window, true), true)));
    }
    return rows;
}

/// A ball of active voxels in a box, about `share` of it.
std::shared_ptr<const Domain> ball(const BoxSize& size, double share)
{
    const openvdb::Vec3d centre(size[0] / 2.0, size[1] / 2.0, size[2] / 2.0);
    const double radius = std::cbrt(share * size[0] * size[1] * size[2] * 3 / (4 * 3.14159265358979));
    auto topology = std::make_shared<openvdb::MaskTree>();
    openvdb::tree::ValueAccessor<openvdb::MaskTree> voxels(*topology);
    for (int x = 0; x < size[0]; ++x) {
        for (int y = 0; y < size[1]; ++y) {
            for (int z = 0; z < size[2]; ++z) {
                if ((openvdb::Vec3d(x, y, z) - centre).length() < radius) voxels.setValueOn({x, y, z});
            }
        }
    }
    return std::make_shared<const Domain>(topology);
}

json sweeps()
{
    json rows;
    const ScatterParams standard;
    header("By life span, 96 x 96 x 96, 6 frames");
    const BoxSize cube{96, 96, 96};
    const Flow flow = analytic(cube, 7, boxDomain(cube));
    for (const int life : {4, 8, 16, 32}) {
        ScatterParams params;
        params.lifeSpan = life;
        rows.push_back(row("life span " + std::to_string(life), run(flow, params, false)));
    }
    header("By size, 3 frames");
    for (const int side : {64, 128, 256, 384}) {
        const BoxSize size{side, side, side};
        rows.push_back(row(std::to_string(side) + " cubed", run(analytic(size, 4, boxDomain(size)), standard, false)));
    }
    header("By share of active voxels, a ball in 192 x 192 x 192, 3 frames");
    const BoxSize box{192, 192, 192};
    for (const double share : {1.0, 0.25, 0.05}) {
        const auto domain = share == 1 ? boxDomain(box) : ball(box, share);
        rows.push_back(row(std::to_string(int(100 * share)) + " %", run(analytic(box, 4, domain), standard, false)));
    }
    header("By threads, 144 x 73 x 81, 6 frames (wall time in the JSON and here)");
    const BoxSize paper{144, 73, 81};
    const Flow paperFlow = analytic(paper, 7, boxDomain(paper));
    double one = 0;
    for (const std::size_t threads : {1, 2}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const Figures figures = run(paperFlow, standard, false);
        rows.push_back(row(std::to_string(threads) + " threads", figures));
        if (threads == 1) one = figures.wallNanoseconds;
        std::printf("wall: %.1f ns per voxel and frame, speed-up %.2f\n", figures.wallNanoseconds,
                    one / figures.wallNanoseconds);
    }
    return rows;
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

/// RK4 steps a second, in scan order, of one voxel's seed each.
json integrators(const Flow& flow)
{
    const Domain& domain = *flow.frames[0].domain;
    VelocityField field;
    flow.build(0, field);
    std::vector<openvdb::Coord> seeds;
    for (auto leaf = domain.topology().cbeginLeaf(); leaf; ++leaf) {
        for (auto voxel = leaf->cbeginValueOn(); voxel; ++voxel)
            seeds.push_back(voxel.getCoord());
    }
    json rows;
    double reference = 0;
    const auto report = [&](const char* name, double seconds) {
        const double rate = 1e-6 * double(seeds.size()) / seconds;
        if (reference == 0) reference = rate;
        std::printf("| %-48s | %6.2f | %5.2f |\n", name, rate, rate / reference);
        rows.push_back({{"name", name}, {"million_steps_per_second", rate}});
    };
    std::printf("\nRK4 steps, 144 x 73 x 81\n\n| | million a second | ratio |\n|---|---|---|\n");

    // GridSampler on two frames, by hand, in voxels per step.
    const auto a = flow.frames[0].velocities->deepCopy(), b = flow.frames[1].velocities->deepCopy();
    for (const auto& [grid, scale] : {std::pair(a, flow.toStep[0](0, 0)), std::pair(b, flow.toStep[1](0, 0))}) {
        for (auto value = grid->beginValueOn(); value; ++value)
            value.setValue(*value * float(scale));
    }
    double sink = 0;
    {
        using Accessor = openvdb::Vec3SGrid::ConstAccessor;
        const Accessor accessorA = a->getConstAccessor(), accessorB = b->getConstAccessor();
        const openvdb::tools::GridSampler<Accessor, openvdb::tools::BoxSampler> start(accessorA, a->transform()),
            end(accessorB, b->transform());
        const auto sample = [&](const openvdb::Vec3R& p, float t) {
            const openvdb::Vec3f v = start.isSample(p), w = end.isSample(p);
            return openvdb::Vec3R(v + (w - v) * t);
        };
        const double before = cpuTime();
        for (const openvdb::Coord& seed : seeds) {
            const openvdb::Vec3R p = seed.asVec3d();
            const openvdb::Vec3R k1 = sample(p, 0), k2 = sample(p + 0.5 * k1, 0.5f), k3 = sample(p + 0.5 * k2, 0.5f),
                                 k4 = sample(p + k3, 1);
            sink += (p + (k1 + 2.0 * (k2 + k3) + k4) / 6.0).x();
        }
        report("GridSampler and BoxSampler, two frames", cpuTime() - before);
    }
    {
        openvdb::tools::VelocityIntegrator<openvdb::Vec3SGrid> integrator(*a);
        const double before = cpuTime();
        for (const openvdb::Coord& seed : seeds) {
            openvdb::Vec3d p = seed.asVec3d();
            integrator.rungeKutta<4>(1.0, p);
            sink += p.x();
        }
        report("OpenVDB's VelocityIntegrator, one frame", cpuTime() - before);
    }
#if __has_include(<nanovdb/NanoVDB.h>)
    {
        const auto first = nanovdb::openToNanoVDB(*a), second = nanovdb::openToNanoVDB(*b);
        const auto accessorA = first.grid<nanovdb::Vec3f>()->getAccessor(),
                   accessorB = second.grid<nanovdb::Vec3f>()->getAccessor();
        const auto start = nanovdb::createSampler<1>(accessorA), end = nanovdb::createSampler<1>(accessorB);
        const auto sample = [&](const nanovdb::Vec3f& p, float t) {
            const nanovdb::Vec3f v = start(p), w = end(p);
            return v + (w - v) * t;
        };
        const double before = cpuTime();
        for (const openvdb::Coord& seed : seeds) {
            const nanovdb::Vec3f p{float(seed[0]), float(seed[1]), float(seed[2])};
            const nanovdb::Vec3f k1 = sample(p, 0), k2 = sample(p + k1 * 0.5f, 0.5f), k3 = sample(p + k2 * 0.5f, 0.5f),
                                 k4 = sample(p + k3, 1);
            sink += double((p + (k1 + (k2 + k3) * 2.0f + k4) / 6.0f)[0]);
        }
        report("NanoVDB, two frames", cpuTime() - before);
    }
#endif
    {
        PathBatch batch;
        PathlineParams coarse;
        coarse.tolerance = 10; // one step each
        const double before = cpuTime();
        bench::advanceAll(field, coarse, batch, sink);
        report("advancePaths, two frames, error estimate", cpuTime() - before);
    }
    if (const std::optional<double> vtk = vtkRate())
        report("VTK's vtkStreamTracer, one frame", 1e-6 * double(seeds.size()) / *vtk);
    std::printf("(%g)\n", sink); // keeps the work from being left out
    return rows;
}

/// Run a tool of the same build. @return its peak of resident memory [bytes]
double peakOf(const std::vector<std::string>& command)
{
    const auto tools = std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "tools";
    std::vector<std::string> words = command;
    words[0] = (tools / command[0]).string();
    std::vector<char*> arguments;
    for (std::string& word : words)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const pid_t child = ::fork();
    if (child == 0) {
        ::dup2(::open("/dev/null", O_WRONLY), STDOUT_FILENO);
        ::execv(arguments[0], arguments.data());
        ::_exit(127);
    }
    int status = 0;
    rusage usage{};
    ::wait4(child, &status, 0, &usage);
    if (status != 0) throw std::runtime_error(command[0] + " failed");
    return 1024.0 * double(usage.ru_maxrss);
}

/// Of vdblic_advect, files and all.
json memory()
{
    std::printf("\nPeak memory of vdblic_advect, whole process, 4 frames\n\n| | bytes per active voxel |\n|---|---|\n");
    const auto folder = std::filesystem::temp_directory_path() / ("vdblic_bench_" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder);
    json rows;
    for (const int side : {64, 128, 256}) {
        const std::string size = std::to_string(side), velocity = (folder / "velocity.%04d.vdb").string();
        (void)peakOf({"vdblic_synth", "abc", "-q", "-o", velocity, "--size", size, size, size, "--frames", "1-4"});
        const double bytes = peakOf({"vdblic_advect", velocity, "-q", "-o", (folder / "lic.%04d.vdb").string()});
        const double perVoxel = bytes / (double(side) * side * side);
        std::printf("| %d cubed | %.0f |\n", side, perVoxel);
        std::fflush(stdout);
        rows.push_back({{"side", side}, {"bytes_per_voxel", perVoxel}});
    }
    std::filesystem::remove_all(folder);
    return rows;
}

} // namespace

int main(int argc, char** argv)
{
    openvdb::initialize();
    int frames = 41;
    std::string velocity, range, output;
    for (int i = 1; i < argc; ++i) {
        const std::string option = argv[i];
        if (option == "--frames" && i + 1 < argc) {
            frames = std::stoi(argv[++i]);
        } else if (option == "--velocity" && i + 2 < argc) {
            velocity = argv[++i];
            range = argv[++i];
        } else if (option == "--json" && i + 1 < argc) {
            output = argv[++i];
        } else {
            std::fprintf(stderr, "engine [--frames N] [--velocity PATTERN RANGE] [--json FILE]\n");
            return 2;
        }
    }
    json report;
    report["memory"] = memory(); // first: a child's peak counts what it had of its parent's
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        const BoxSize paper{144, 73, 81};
        const Flow flow = analytic(paper, frames + 1, boxDomain(paper));
        report["integrators"] = integrators(flow);
        report["methods"] = methods(flow, "The paper's grid, 144 x 73 x 81, abc flow, life span 4");
        if (!velocity.empty()) {
            report["methods_of_files"] = methods(fromFiles(velocity, range), "The given files, life span 4");
        }
    }
    report["sweeps"] = sweeps();
    if (!output.empty()) std::ofstream(output) << report.dump(2) << '\n';
}
