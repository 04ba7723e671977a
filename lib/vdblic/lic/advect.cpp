#include "vdblic/lic/advect.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/flow_texture.h"
#include "vdblic/lic/noise.h"

#include <cmath>
#include <future>

namespace vdblic {
namespace {

constexpr double kDefaultFps = 24;
constexpr int kMaxPreroll = 10000;

/// A frame that was read, with the domain it is computed on.
struct LoadedFrame {
    VelocityFrame velocity;
    FlowFrame flow;
};

LoadedFrame load(const FrameFile& file, const VelocityParams& params)
{
    LoadedFrame frame;
    frame.velocity = readVelocity(file, params);
    frame.flow.velocities = frame.velocity.values;
    auto topology =
        std::make_shared<openvdb::MaskTree>(frame.velocity.values->tree(), false, true, openvdb::TopologyCopy());
    frame.flow.domain = std::make_shared<Domain>(std::move(topology));
    return frame;
}

/// Reads one frame ahead of the one that is asked for.
class FrameReader {
  public:
    FrameReader(FrameSource source, const VelocityParams& params) : mSource(std::move(source)), mParams(params)
    {
        readAhead();
    }

    std::optional<LoadedFrame> next()
    {
        if (!mAhead.valid()) return std::nullopt;
        std::optional<LoadedFrame> frame = mAhead.get();
        if (frame) readAhead();
        return frame;
    }

  private:
    void readAhead()
    {
        mAhead = std::async(std::launch::async, [this]() -> std::optional<LoadedFrame> {
            const std::optional<FrameFile> file = mSource();
            if (!file) return std::nullopt;
            return load(*file, mParams);
        });
    }

    FrameSource mSource;
    VelocityParams mParams;
    std::future<std::optional<LoadedFrame>> mAhead;
};

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

openvdb::Int32Grid::ConstPtr readNoise(const std::string& argument)
{
    std::filesystem::path path = argument;
    std::string name = "noise";
    if (const auto colon = argument.rfind(':'); colon != std::string::npos && !std::filesystem::exists(path)) {
        path = argument.substr(0, colon);
        name = argument.substr(colon + 1);
    }
    const VdbFile file = readVdb(path);
    const auto grid = file.find<openvdb::Int32Grid>(name);
    if (!grid) {
        throw InputError(fmt::format("{}: no int32 grid '{}' as vdblic_noise writes it; the file holds {}",
                                     path.string(), name, file.contents()));
    }
    for (auto value = grid->cbeginValueOn(); value; ++value) {
        if (*value < 0 || *value > kNoiseMax) {
            const openvdb::Coord at = value.getCoord();
            throw InputError(fmt::format("{}: grid {}: value {} at [{}, {}, {}] is outside 0 to {}", path.string(),
                                         name, *value, at[0], at[1], at[2], kNoiseMax));
        }
    }
    return grid;
}

openvdb::MetaMap parameterMetadata(const AdvectParams& params, int preroll)
{
    openvdb::MetaMap metadata;
    const bool auflic = params.scatter.method == ScatterMethod::kAuflic;
    metadata.insertMeta("method", openvdb::StringMetadata(auflic ? "auflic" : "uflic"));
    metadata.insertMeta("life_span", openvdb::Int32Metadata(params.scatter.lifeSpan));
    if (auflic) metadata.insertMeta("release_window", openvdb::FloatMetadata(params.scatter.releaseWindow));
    metadata.insertMeta("sample_spacing", openvdb::FloatMetadata(params.scatter.pathline.sampleSpacing));
    metadata.insertMeta("tolerance", openvdb::FloatMetadata(params.scatter.pathline.tolerance));
    metadata.insertMeta("sharpen", openvdb::FloatMetadata(params.feedback.sharpen));
    metadata.insertMeta("jitter", openvdb::StringMetadata(std::string(toString(params.feedback.jitter))));
    metadata.insertMeta("noise_share", openvdb::FloatMetadata(params.feedback.noiseShare));
    metadata.insertMeta("preroll", openvdb::Int32Metadata(preroll));
    if (params.noise.empty()) {
        metadata.insertMeta("seed", openvdb::Int64Metadata(params.seed));
    } else {
        metadata.insertMeta("noise", openvdb::StringMetadata(params.noise));
    }
    return metadata;
}

/// The whole run: state that outlives a frame.
class Advection {
  public:
    Advection(const AdvectParams& params, std::istream& lines, Reporter& reporter)
        : mParams(params), mReporter(reporter), mPattern(params.output),
          mTexture(params.scatter, params.feedback,
                   NoiseField(params.seed, params.noise.empty() ? nullptr : readNoise(params.noise))),
          mReader(openSequence(params.input, lines, mTotal), params.velocity), mWriter(reporter, mTotal)
    {
        if (mTotal > 0) checkOutputPattern(mPattern, mTotal);
    }

    void run()
    {
        std::optional<LoadedFrame> current = mReader.next();
        if (!current) {
            mReporter.warn("no frames on standard input; nothing was computed");
            return;
        }
        if (!current->velocity.remark.empty()) mReporter.say(current->velocity.remark);
        if (current->velocity.time) mTime = *current->velocity.time;

        const int preroll = mParams.preroll.value_or(mParams.scatter.lifeSpan);
        mParameters = parameterMetadata(mParams, preroll);
        std::optional<LoadedFrame> next = mReader.next();
        const double firstInterval = interval(*current, next ? &*next : nullptr);
        for (int i = 0; i < preroll; ++i)
            advance(*current, *current, firstInterval);

        double last = firstInterval;
        while (current) {
            if (next) {
                checkSuccession(*current, *next);
                last = interval(*current, &*next);
            }
            // The last frame's flow is taken to go on as it is.
            write(*current, advance(*current, next ? *next : *current, last), last);
            mTime += last;
            current = std::move(next);
            next = current ? mReader.next() : std::nullopt;
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
    double interval(const LoadedFrame& current, const LoadedFrame* next)
    {
        if (mParams.interval) return *mParams.interval;
        if (next && current.velocity.time && next->velocity.time) {
            const double seconds = *next->velocity.time - *current.velocity.time;
            if (seconds > 0 && std::isfinite(seconds)) return seconds;
            throw InputError(
                fmt::format("{}: its time {} does not come after the time {} of the frame before; give the "
                            "frame spacing with --dt or --fps",
                            next->velocity.file.path.string(), *next->velocity.time, *current.velocity.time));
        }
        if (current.velocity.dt && *current.velocity.dt > 0) return *current.velocity.dt;
        if (!mSaidDefault)
            mReporter.say(fmt::format("no time or dt in the files: taking {} frames a second", kDefaultFps));
        mSaidDefault = true;
        return 1 / kDefaultFps;
    }

    static void checkSuccession(const LoadedFrame& current, const LoadedFrame& next)
    {
        if (current.velocity.values->transform() == next.velocity.values->transform()) return;
        throw InputError(fmt::format("{}: grid {}: the transform differs from that of the frame before; resample the "
                                     "sequence onto one grid",
                                     next.velocity.file.path.string(), next.velocity.gridName));
    }

    FlowTextureStep advance(LoadedFrame& start, LoadedFrame& end, double seconds)
    {
        start.flow.toWorldPerSecond = start.velocity.toWorldPerSecond(seconds);
        return mTexture.advance({start.flow, end.flow, start.velocity.toVoxelsPerStep(seconds),
                                 end.velocity.toVoxelsPerStep(seconds), seconds});
    }

    void write(const LoadedFrame& frame, const FlowTextureStep& step, double seconds)
    {
        const auto texture = openvdb::FloatGrid::create(step.texture.tree());
        texture->setName(mParams.textureName);
        const auto magnitude = magnitudeGrid(frame.flow);
        magnitude->setName("magnitude");
        for (const auto& grid : {texture, magnitude}) {
            grid->setTransform(frame.velocity.values->transform().copy());
            grid->setGridClass(openvdb::GRID_FOG_VOLUME);
        }
        openvdb::MetaMap metadata = mParameters;
        metadata.insertMeta("frame", openvdb::Int64Metadata(frame.velocity.file.frame));
        metadata.insertMeta("time", openvdb::DoubleMetadata(mTime));
        metadata.insertMeta("dt", openvdb::DoubleMetadata(seconds));
        mReporter.detail(fmt::format(
            "frame {}: {} voxels, {} particles, {} released, {} reused, {} copied, {} steps, {} "
            "deposits",
            frame.velocity.file.frame, frame.flow.domain->voxelCount(), step.stats.particles, step.stats.released,
            step.stats.reused, step.stats.copied, step.stats.steps, step.stats.deposits));
        mWriter.write(mPattern.path(frame.velocity.file.frame), {texture, magnitude}, std::move(metadata));
    }

    const AdvectParams& mParams;
    Reporter& mReporter;
    FramePattern mPattern;
    FlowTexture mTexture;
    std::size_t mTotal = 0;
    FrameReader mReader;
    FrameWriter mWriter;
    openvdb::MetaMap mParameters;
    double mTime = 0;
    bool mSaidDefault = false;
};

} // namespace

void AdvectParams::validate() const
{
    velocity.validate();
    scatter.validate();
    feedback.validate();
    if (interval && !(*interval > 0 && std::isfinite(*interval))) {
        throw ParameterError(fmt::format("the frame spacing of {} s must be above 0", *interval));
    }
    if (preroll && (*preroll < 0 || *preroll > kMaxPreroll)) {
        throw ParameterError(fmt::format("preroll {} must lie between 0 and {}", *preroll, kMaxPreroll));
    }
    if (textureName.empty() || textureName == "magnitude") {
        throw ParameterError(fmt::format("'{}' cannot be the texture's name", textureName));
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
