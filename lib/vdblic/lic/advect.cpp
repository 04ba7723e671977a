#include "vdblic/lic/advect.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/derived_grids.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/grid_reference.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/flow_sequence.h"
#include "vdblic/lic/flow_texture.h"

#include <future>

namespace vdblic {
namespace {

constexpr int kMaxPreroll = 10000;

/// Writes one file while the next is computed.
class FrameWriter {
  public:
    FrameWriter(Reporter& reporter, std::size_t total) : mReporter(reporter), mTotal(total) {}

    void write(std::filesystem::path path, openvdb::GridCPtrVec grids, openvdb::MetaMap metadata)
    {
        finish();
        mPath = std::move(path);
        mPending = std::async(std::launch::async, [this, grids = std::move(grids), metadata = std::move(metadata)] {
            writeVdb(mPath, grids, metadata);
        });
    }

    void finish()
    {
        if (!mPending.valid()) return;
        mPending.get();
        mReporter.finished(mPath);
        mReporter.progress(++mDone, mTotal);
    }

  private:
    Reporter& mReporter;
    std::size_t mTotal, mDone = 0;
    std::filesystem::path mPath;
    std::future<void> mPending;
};

openvdb::FloatGrid::Ptr magnitudeGrid(const FlowFrame& frame)
{
    const LeafValues<float> magnitude(*frame.domain, 0.0f);
    const openvdb::Mat3s toWorld(frame.toWorldPerSecond);
    tbb::parallel_for(std::size_t(0), frame.domain->leafCount(), [&](std::size_t leaf) {
        const auto values = frame.velocities->getConstAccessor();
        for (auto voxel = frame.domain->mask(leaf).beginOn(); voxel; ++voxel) {
            const openvdb::Coord at = frame.domain->origin(leaf) + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            magnitude[leaf][voxel.pos()] = (toWorld * values.getValue(at)).length();
        }
    });
    return openvdb::FloatGrid::create(magnitude.tree());
}

openvdb::FloatGrid::ConstPtr readNoise(const std::string& argument)
{
    const auto [path, named] = parseGridReference(argument);
    const std::string name = named.empty() ? "noise" : named;
    const VdbFile file = readVdb(path);
    const auto grid = file.find<openvdb::FloatGrid>(name);
    if (!grid) {
        throw InputError(fmt::format("{}: no float grid '{}'; the file holds {}: choose with FILE:GRID", path.string(),
                                     name, file.contents()));
    }
    for (auto value = grid->cbeginValueOn(); value; ++value) {
        if (!(*value >= 0 && *value <= 1)) {
            const openvdb::Coord at = value.getCoord();
            throw InputError(fmt::format("{}: grid {}: value {} at [{}, {}, {}] is outside 0 to 1", path.string(), name,
                                         *value, at[0], at[1], at[2]));
        }
    }
    return grid;
}

openvdb::MetaMap parameterMetadata(const AdvectParams& params, int preroll)
{
    openvdb::MetaMap metadata;
    const bool auflic = params.scatter.method == ScatterMethod::kAuflic;
    metadata.insertMeta("method", openvdb::StringMetadata(params.steady ? "lic" : auflic ? "auflic" : "uflic"));
    if (params.steady) metadata.insertMeta("kernel", openvdb::StringMetadata(std::string(toString(*params.steady))));
    metadata.insertMeta("life_span", openvdb::Int32Metadata(params.scatter.lifeSpan));
    if (auflic && !params.steady) {
        metadata.insertMeta("release_window", openvdb::FloatMetadata(params.scatter.releaseWindow));
        metadata.insertMeta("history", openvdb::BoolMetadata(params.scatter.history));
    }
    metadata.insertMeta("sample_spacing", openvdb::FloatMetadata(params.scatter.pathline.sampleSpacing));
    metadata.insertMeta("tolerance", openvdb::FloatMetadata(params.scatter.pathline.tolerance));
    if (!params.steady) {
        metadata.insertMeta("sharpen", openvdb::FloatMetadata(params.feedback.sharpen));
        metadata.insertMeta("jitter", openvdb::StringMetadata(std::string(toString(params.feedback.jitter))));
        metadata.insertMeta("noise_share", openvdb::FloatMetadata(params.feedback.noiseShare));
        metadata.insertMeta("preroll", openvdb::Int32Metadata(preroll));
    }
    if (params.noise.empty()) {
        metadata.insertMeta("seed", openvdb::Int64Metadata(params.seed));
    } else {
        metadata.insertMeta("noise", openvdb::StringMetadata(params.noise));
    }
    return metadata;
}

FlowSequenceParams flowParams(const AdvectParams& params)
{
    return {params.input, params.velocity, params.frameSpacing, params.domain};
}

/// The whole run: state that outlives a frame.
class Advection {
  public:
    Advection(const AdvectParams& params, std::istream& lines, Reporter& reporter)
        : mParams(params), mReporter(reporter), mPattern(params.output),
          mTexture(params.scatter, params.feedback,
                   NoiseField(params.seed, params.noise.empty() ? nullptr : readNoise(params.noise)), params.steady),
          mFlow(flowParams(params), lines, reporter), mWriter(reporter, mFlow.total())
    {
        if (mFlow.total() > 0) checkOutputPattern(mPattern, mFlow.total());
    }

    void run()
    {
        std::optional<LoadedFrame> current = mFlow.next();
        mReporter.checkStop(); // it may have ended standard input
        if (!current) {
            mReporter.warn("no frames on standard input; nothing was computed");
            return;
        }
        const int preroll = mParams.preroll.value_or(mParams.steady ? 0 : mParams.scatter.lifeSpan);
        mParameters = parameterMetadata(mParams, preroll);
        mTime = current->velocity.time.value_or(0);
        checkOutput(*current);
        std::optional<LoadedFrame> next = mFlow.next();
        FrameInterval interval = mFlow.intervalAfter(*current, next ? &*next : nullptr);
        mFlow.describe(*current, interval);
        for (int i = 0; i < preroll; ++i)
            advance(*current, *current, interval.seconds);

        while (current) {
            if (next) interval = mFlow.intervalAfter(*current, &*next);
            // The last frame's flow is taken to go on as it is.
            write(*current, advance(*current, next ? *next : *current, interval.seconds), interval.seconds);
            mTime += interval.seconds;
            current = std::move(next);
            if (current) checkOutput(*current);
            next = current ? mFlow.next() : std::nullopt;
        }
        mWriter.finish();
    }

    /// Finish what is being written, after an error elsewhere.
    void abandon() noexcept
    {
        try {
            mWriter.finish();
        } catch (...) { // the first error is the one to report
        }
    }

  private:
    /// What is written must not replace what is read.
    void checkOutput(const LoadedFrame& frame) const
    {
        const std::int64_t number = frame.velocity.file.frame;
        const std::filesystem::path output = mPattern.path(number);
        checkNotInput(output, frame.velocity.file.path);
        for (const std::string& reference : {mParams.noise, mParams.domain.mask}) {
            if (reference.empty()) continue;
            checkNotInput(output, FramePattern(parseGridReference(reference).path.string()).path(number));
        }
    }

    FlowTextureStep advance(LoadedFrame& start, LoadedFrame& end, double seconds)
    {
        mReporter.checkStop();
        start.flow.toWorldPerSecond = start.velocity.toWorldPerSecond(seconds);
        return mTexture.advance({start.flow, end.flow, start.velocity.toVoxelsPerStep(seconds),
                                 end.velocity.toVoxelsPerStep(seconds), seconds});
    }

    void write(const LoadedFrame& frame, const FlowTextureStep& step, double seconds)
    {
        checkFlow(frame, seconds);
        const auto texture = openvdb::FloatGrid::create(step.texture.tree());
        texture->setName(mParams.textureName);
        const auto magnitude = magnitudeGrid(frame.flow);
        magnitude->setName("magnitude");
        for (const auto& grid : {texture, magnitude}) {
            grid->setTransform(frame.velocity.values->transform().copy());
            grid->setGridClass(openvdb::GRID_FOG_VOLUME);
        }
        openvdb::GridCPtrVec grids = {texture, magnitude};
        for (auto& grid :
             derivedGrids(mParams.derived, *frame.flow.domain, *frame.velocity.values, frame.flow.toWorldPerSecond))
            grids.push_back(std::move(grid));
        grids.insert(grids.end(), frame.velocity.carried.begin(), frame.velocity.carried.end());
        openvdb::MetaMap metadata = mParameters;
        if (!frame.velocity.sourceCreator.empty()) {
            metadata.insertMeta("source_creator", openvdb::StringMetadata(frame.velocity.sourceCreator));
        }
        metadata.insertMeta("frame", openvdb::Int64Metadata(frame.velocity.file.frame));
        metadata.insertMeta("time", openvdb::DoubleMetadata(mTime));
        metadata.insertMeta("dt", openvdb::DoubleMetadata(seconds));
        mReporter.detail(fmt::format("frame {}: {} voxels; particles: {} went on, {} blocked, {} released; seeds: {} "
                                     "reused, {} copied; {} steps, {} "
                                     "deposits; seconds: load {:.3f}, scatter {:.3f}, convolve {:.3f}, filter {:.3f}",
                                     frame.velocity.file.frame, frame.flow.domain->voxelCount(), step.stats.particles,
                                     step.stats.blocked, step.stats.released, step.stats.reused, step.stats.copied,
                                     step.stats.steps, step.stats.deposits, step.times.load, step.times.scatter,
                                     step.times.convolve, step.times.filter));
        mWriter.write(mPattern.path(frame.velocity.file.frame), std::move(grids), std::move(metadata));
    }

    /// What is odd about a frame, though it can be computed.
    void checkFlow(const LoadedFrame& frame, double seconds)
    {
        const std::int64_t number = frame.velocity.file.frame;
        if (frame.flow.domain->voxelCount() == 0) {
            mReporter.warn(fmt::format("frame {}: {}: no active voxels; its texture is empty", number,
                                       frame.velocity.file.path.string()));
            return;
        }
        const double largest = frame.velocity.largestDisplacement(seconds);
        if (largest <= kLargeDisplacement || mWarnedOfDisplacement) return;
        mWarnedOfDisplacement = true;
        mReporter.warn(
            fmt::format("frame {}: the flow moves up to {:.1f} voxels a step; over more than {} it is hardly "
                        "linear in time between frames: check unit and frame spacing, or use frames closer in time",
                        number, largest, kLargeDisplacement));
    }

    const AdvectParams& mParams;
    Reporter& mReporter;
    FramePattern mPattern;
    FlowTexture mTexture;
    FlowSequence mFlow;
    FrameWriter mWriter;
    openvdb::MetaMap mParameters;
    double mTime = 0;
    bool mWarnedOfDisplacement = false;
};

} // namespace

void AdvectParams::validate() const
{
    flowParams(*this).validate();
    scatter.validate();
    feedback.validate();
    if (preroll && (*preroll < 0 || *preroll > kMaxPreroll)) {
        throw ParameterError(fmt::format("preroll {} must lie between 0 and {}", *preroll, kMaxPreroll));
    }
    checkDerivedNames(derived);
    const auto isOutput = [&](const std::string& name) {
        return name == "magnitude" || std::find(derived.begin(), derived.end(), name) != derived.end();
    };
    if (textureName.empty() || isOutput(textureName)) {
        throw ParameterError(fmt::format("'{}' cannot be the texture's name", textureName));
    }
    for (const std::string& name : velocity.carry) {
        if (name != textureName && !isOutput(name)) continue;
        throw ParameterError(fmt::format("the grid '{}' to carry along has the name of an output; leave one of the two "
                                         "out, or give --texture-name another",
                                         name));
    }
}

void advectSequence(const AdvectParams& params, std::istream& lines, Reporter& reporter)
{
    params.validate();
    Advection advection(params, lines, reporter);
    try {
        advection.run();
    } catch (...) {
        advection.abandon();
        throw;
    }
}

} // namespace vdblic
