#include "advection.h"

#include "vdblic/field/domain_mask.h"
#include "vdblic/run/advect.h"

#include <chrono>
#include <istream>
#include <utility>
#include <vector>

namespace vdblic::python {

AdvectParams advectParams(const Options& options)
{
    AdvectParams params;
    options.set("input", params.input.pattern);
    options.set("frames", params.input.frames);
    options.set("clamp_frames", params.input.clampFrames);
    options.set("output", params.output);
    const std::string method = options.has("method") ? options.get<std::string>("method") : "auflic";
    if (method == "uflic") {
        params.scatter.method = ScatterMethod::kUflic;
    } else if (method == "lic") {
        params.steady = parseLicKernel(options.has("kernel") ? options.get<std::string>("kernel") : "hann");
    } else if (method != "auflic") {
        throw ParameterError(fmt::format("method '{}' is none of auflic, uflic and lic", method));
    }
    options.set("life_span", params.scatter.lifeSpan);
    options.set("substeps", params.scatter.substeps);
    options.set("release_window", params.scatter.releaseWindow);
    options.set("sample_spacing", params.scatter.pathline.sampleSpacing);
    options.set("tolerance", params.scatter.pathline.tolerance);
    options.set("velocity", params.velocity.grid);
    options.set("velocity_scale", params.velocity.scale);
    options.set("carry", params.velocity.carry);
    if (options.has("velocity_unit"))
        params.velocity.unit = parseVelocityUnit(options.get<std::string>("velocity_unit"));
    if (options.has("non_finite")) {
        const auto text = options.get<std::string>("non_finite");
        if (text != "refuse" && text != "zero")
            throw ParameterError(fmt::format("`non_finite` '{}' is neither refuse nor zero", text));
        params.velocity.nonFinite = text == "zero" ? NonFinite::kZero : NonFinite::kRefuse;
    }
    options.set("frame_spacing", params.frameSpacing);
    options.set("mask", params.domain.mask);
    options.set("box", params.domain.box);
    options.set("world_box", params.domain.worldBox);
    options.set("refine", params.domain.refinement.factors);
    options.parse<Interpolation>("interpolation", params.domain.refinement.interpolation, parseInterpolation);
    options.set("sharpen", params.feedback.sharpen);
    options.parse<Jitter>("jitter", params.feedback.jitter, parseJitter);
    options.set("noise_share", params.feedback.noiseShare);
    options.set("finish", params.finish.taps);
    options.set("noise", params.noise);
    options.set("seed", params.seed);
    options.set("preroll", params.preroll);
    options.set("lead_in", params.leadIn);
    options.set("derived", params.derived);
    options.set("texture_name", params.textureName);
    options.parse<GridPrecision>("precision", params.format.precision, parseGridPrecision);
    options.parse<ScalarVoxels>("scalars", params.format.scalars, parseScalarVoxels);
    params.format.compression = VdbCompression::kNone; // the files are read at once
    params.checkpointEvery = 0;
    params.validate();
    return params;
}

AdvectionRun::AdvectionRun(AdvectParams params) : mParams(std::move(params))
{
    mThread = std::thread([this] {
        try {
            std::istream lines(this);
            advectSequence(mParams, lines, *this);
        } catch (const Stopped&) { // the caller knows
        } catch (...) {
            mError = std::current_exception();
        }
        tell({Kind::kDone, {}});
    });
}

AdvectionRun::~AdvectionRun()
{
    stop();
    mThread.join();
}

void AdvectionRun::stop()
{
    const std::lock_guard lock(mMutex);
    mStopped = true;
    mChanged.notify_all();
}

AdvectionRun::Event AdvectionRun::next()
{
    std::unique_lock lock(mMutex);
    if (!mChanged.wait_for(lock, std::chrono::milliseconds(100), [&] { return !mEvents.empty(); })) return {};
    Event event = std::move(mEvents.front());
    mEvents.pop();
    mChanged.notify_all();
    if (event.kind == Kind::kDone && mError) std::rethrow_exception(mError);
    return event;
}

void AdvectionRun::answer(const std::string& path)
{
    const std::lock_guard lock(mMutex);
    mAnswer = path;
    mChanged.notify_all();
}

bool AdvectionRun::stopRequested() const
{
    const std::lock_guard lock(mMutex);
    return mStopped;
}

void AdvectionRun::tell(Event event)
{
    const std::lock_guard lock(mMutex);
    mEvents.push(std::move(event));
    mChanged.notify_all();
}

/// The run goes on once the output is taken: no more than one is on disk.
void AdvectionRun::finished(const std::filesystem::path& output)
{
    tell({Kind::kFinished, output.string()});
    std::unique_lock lock(mMutex);
    mChanged.wait(lock, [&] { return mStopped || mEvents.empty(); });
}

AdvectionRun::int_type AdvectionRun::underflow()
{
    if (mEnded) return traits_type::eof();
    tell({Kind::kNeeds, {}});
    std::unique_lock lock(mMutex);
    mChanged.wait(lock, [&] { return mStopped || mAnswer; });
    mEnded = mStopped || mAnswer->empty();
    if (mEnded) return traits_type::eof();
    mLine = *mAnswer + '\n';
    mAnswer.reset();
    setg(mLine.data(), mLine.data(), mLine.data() + mLine.size());
    return traits_type::to_int_type(*gptr());
}

} // namespace vdblic::python
