#include "vdblic/methods/streaks/streak_texture.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/message.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/field/domain_rows.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/neighbourhood_grid.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/lic/path_reach.h"
#include "vdblic/methods/streaks/streak_controller.h"
#include "vdblic/methods/streaks/streak_drawing.h"
#include "vdblic/methods/streaks/streak_lines.h"
#include "vdblic/methods/streaks/streak_paths.h"

#include "vdblic/methods/streaks/streak_state.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdblic {
namespace {

/// Turns of the controller per frame.
constexpr int kTurns = 2;
/// Attempts to fill the domain with the first streaks; later releases fill gaps of the flow.
constexpr int kFirstAttempts = 16;

/// The drawn leaves of all ranks as one domain. Collective.
std::shared_ptr<const Domain> drawnDomain(const openvdb::FloatTree& own, const LeafOwners& owners)
{
    auto topology = std::make_shared<openvdb::MaskTree>(own, false, true, openvdb::TopologyCopy());
    if (!owners.areSeveral()) return std::make_shared<const Domain>(topology);
    Exchange::Bytes message;
    for (auto leaf = own.cbeginLeaf(); leaf; ++leaf) {
        put(message, leaf->origin().data(), 3);
        for (openvdb::Index word = 0; word < Domain::Mask::WORD_COUNT; ++word)
            put(message, leaf->getValueMask().getWord<std::uint64_t>(word));
    }
    for (const Exchange::Bytes& bytes : owners.tell(message)) {
        for (MessageReader reader(bytes); !reader.atEnd();) {
            openvdb::Coord origin;
            reader.get(origin.data(), 3);
            Domain::Mask drawn;
            for (openvdb::Index word = 0; word < Domain::Mask::WORD_COUNT; ++word)
                drawn.getWord<std::uint64_t>(word) = reader.get<std::uint64_t>();
            topology->touchLeaf(origin)->setValueMask(drawn);
        }
    }
    const Domain all(topology);
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t leaf = 0; leaf < all.leafCount(); ++leaf) {
        if (own.probeConstLeaf(all.origin(leaf))) numbers.push_back(leaf);
    }
    return all.ofRank(numbers, numbers);
}

openvdb::MaskTree::Ptr copyOf(const openvdb::MaskTree& tree)
{
    return std::make_shared<openvdb::MaskTree>(tree);
}

} // namespace

StreakTexture::StreakTexture(const TextureParams& texture, StreakParams params, const Refinement& refinement,
                             std::uint32_t seed)
    : mTexture(texture), mParams(std::move(params)), mGiven(refinement), mSeed(seed)
{
    mParams.validate();
}

std::string StreakTexture::choose(const Domain& velocity, double displacement)
{
    mShape = streakShape(mParams, mGiven, velocity, displacement);
    return fmt::format("streaks: {}", mShape.text());
}

TextureFrame StreakTexture::advance(const FlowStep& step)
{
    TextureFrame result(step);
    StageClock clock;
    const int substeps = mTexture.substeps;
    const std::uint64_t substep = mStep % std::uint64_t(substeps);
    const Domain& domain = *step.start.domain.velocity;
    mIsSaver = !step.owners.areSeveral() || domain.isOwn(0);
    if (substep == 0) traceFrame(step.whole ? *step.whole : step, step.owners, result, clock);
    result.refinement = mShape.refinement;
    const auto& [x, y, z] = mShape.spacing;
    result.metadata.insertMeta(kInactiveKey, openvdb::StringMetadata(kEmpty));
    result.metadata.insertMeta("spacing", openvdb::Vec3SMetadata({x, y, z}));
    result.metadata.insertMeta("tail", openvdb::FloatMetadata(mShape.tail));
    const std::vector<StreakSource> sources = sourcesOf(mParams);
    for (std::size_t i = 0; i < sources.size(); ++i)
        result.metadata.insertMeta(kSourceKey + std::to_string(i + 1), openvdb::StringMetadata(sources[i].name));
    if (step.isShown) {
        const auto stage = clock.enter(&StageTimes::convolve);
        const double time = double(mStep) / substeps;
        if (mParams.draw == StreakForm::kLines) {
            result.lines = streakLines(mStreaks, mShape, domain, time, step.start.values->transform());
        } else {
            const DrawnStreaks drawn = drawStreaks(mStreaks, mShape, domain, time, !mParams.sources.empty());
            result.domain = drawnDomain(*drawn.texture, step.owners);
            result.texture = LeafValues<float>(*result.domain, drawn.texture);
            if (drawn.source) result.source = LeafValues<float>(*result.domain, drawn.source);
        }
    }
    result.times = clock.times();
    ++mStep;
    return result;
}

/// Trace all streaks through a frame, with the controller's turns.
void StreakTexture::traceFrame(const FlowStep& flow, const LeafOwners& owners, TextureFrame& result, StageClock& clock)
{
    const auto stage = clock.enter(&StageTimes::scatter);
    const std::uint64_t number = mStep / std::uint64_t(mTexture.substeps);
    const auto frame = double(number);
    const VelocityFrame &start = flow.start, &end = flow.end;
    const std::int64_t fileNumber = start.file.frame;
    const std::shared_ptr<const Domain>& domain = start.domain.velocity;
    const bool isFirst = !std::exchange(mHasBegun, true);
    VelocityField field;
    {
        const auto load = clock.enter(&StageTimes::load);
        field.build(domain, flow.startVelocities(), flow.endVelocities());
    }
    forgetPast(frame);
    const std::shared_ptr<const Domain> region = emittingPart(start, fileNumber);
    if (isFirst) {
        const StreakTurn turn{field, *domain, frame, 0, 0, mShape.reach()};
        NeighbourhoodGrid heads(mShape.spacing, domain->period());
        for (std::uint64_t attempt = 0; attempt < kFirstAttempts; ++attempt) {
            const auto places = freePlaces(mStreaks, heads, mShape.spacing, *domain, *region, mSeed, ~attempt);
            const std::size_t before = mStreaks.size();
            addFirstStreaks(turn, mTexture.pathline, *region, double(mShape.tail), places, owners, mStreaks);
            addLive(mStreaks, before, heads);
            result.stats.released += places.size();
        }
        sortByPlace();
        markSources(start, fileNumber);
    } else if (mLastInterval > 0 && mLastInterval != flow.seconds()) {
        const auto scale = float(flow.seconds() / mLastInterval);
        for (Streak& streak : mStreaks) {
            for (float& slope : streak.path.back().slope)
                slope *= scale;
        }
    }
    mLastInterval = flow.seconds();
    for (int i = 0; i < kTurns; ++i) {
        const bool isLast = i + 1 == kTurns;
        const VelocityFrame& there = isLast ? end : start;
        const StreakTurn turn{field,         *there.domain.velocity, frame, float(i) / kTurns, float(i + 1) / kTurns,
                              mShape.reach()};
        result.stats.steps += advanceStreaks(turn, mTexture.pathline, owners, mStreaks);
        NeighbourhoodGrid heads(mShape.spacing, domain->period());
        addLive(mStreaks, 0, heads);
        if (!mParams.emits()) result.stats.blocked += retireCrowded(mStreaks, heads, turn.endTime());
        const std::shared_ptr<const Domain> emitting = isLast ? emittingPart(end, fileNumber) : region;
        const auto places =
            freePlaces(mStreaks, heads, mShape.spacing, turn.end, *emitting, mSeed, number * kTurns + std::uint64_t(i));
        addStreaks(turn, mTexture.pathline, *emitting, places, owners, mStreaks);
        result.stats.released += places.size();
        markSources(there, fileNumber);
    }
    result.stats.particles = std::size_t(
        std::count_if(mStreaks.begin(), mStreaks.end(), [](const Streak& streak) { return streak.isLive(); }));
}

/// The velocity voxels that release streaks. @param number of the frame, for sequences of grids
std::shared_ptr<const Domain> StreakTexture::emittingPart(const VelocityFrame& frame, std::int64_t number) const
{
    const std::shared_ptr<const Domain>& domain = frame.domain.velocity;
    if (!mParams.emits()) return domain;
    DomainParams cut;
    cut.mask = mParams.emit;
    cut.worldBox = mParams.emitBox;
    auto region =
        makeDomain(copyOf(domain->topology()), *frame.inWorld(frame.values->transform()), cut, number).velocity;
    if (region->voxelCount() > 0 || mStep > 0) return region;
    throw InputError(fmt::format("{}: no voxel of the velocity is in it: streaks would be released nowhere",
                                 mParams.emit.empty() ? "`emit_box`" : "`emit` " + mParams.emit));
}

/// Give streaks the number of their current source.
void StreakTexture::markSources(const VelocityFrame& frame, std::int64_t number)
{
    const std::vector<StreakSource> sources = sourcesOf(mParams);
    const openvdb::math::Transform::ConstPtr inWorld = frame.inWorld(frame.values->transform());
    for (std::size_t i = 0; i < sources.size(); ++i) {
        DomainParams cut;
        cut.mask = sources[i].grid;
        const FrameDomain region = makeDomain(copyOf(frame.domain.velocity->topology()), *inWorld, cut, number);
        for (Streak& streak : mStreaks) {
            const auto& [x, y, z] = streak.path.back().position;
            if (!streak.isStopped && covers(*region.velocity, Float4{x, y, z, 0})) streak.source = std::uint8_t(i + 1);
        }
    }
}

/// Erase streaks that stay invisible, and nodes beyond all tails.
void StreakTexture::forgetPast(double time)
{
    const auto tail = double(mShape.tail);
    std::erase_if(mStreaks, [&](const Streak& streak) { return streak.isGone(time, tail); });
    tbb::parallel_for(std::size_t(0), mStreaks.size(), [&](std::size_t i) {
        std::vector<StreakNode>& path = mStreaks[i].path;
        const auto first =
            std::find_if(path.begin(), path.end(), [&](const StreakNode& node) { return node.time > time - tail; });
        // The previous node is an end of the curve in which the tail ends.
        path.erase(path.begin(), first == path.begin() ? first : first - 1);
    });
    sortByPlace();
}

/// Order streaks by the leaves of their heads, so that neighbours in space are near in memory.
void StreakTexture::sortByPlace()
{
    std::vector<std::pair<openvdb::Coord, std::uint32_t>> places(mStreaks.size());
    tbb::parallel_for(std::size_t(0), places.size(), [&](std::size_t i) {
        const auto& [x, y, z] = mStreaks[i].path.back().position;
        const Int4 voxel = voxelOf(Float4{x, y, z, 0});
        places[i] = {openvdb::Coord(voxel[0], voxel[1], voxel[2]) & ~(LeafVoxel::kDim - 1), std::uint32_t(i)};
    });
    tbb::parallel_sort(places);
    std::vector<Streak> sorted;
    sorted.reserve(mStreaks.size());
    for (const auto& place : places)
        sorted.push_back(std::move(mStreaks[place.second]));
    mStreaks = std::move(sorted);
}

Lengths<Space::kTexture> StreakTexture::farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                     double /*seconds*/) const
{
    const float frames = mHasBegun ? 1 : std::max(mShape.tail, 1.0f); // the first tails are traced back at once
    Lengths<Space::kTexture> farthest;
    for (std::size_t axis = 0; axis < 3; ++axis)
        farthest.along[axis] = longestPath(frames * fastest[axis]);
    return farthest;
}

TextureMemory::Saved StreakTexture::save(std::size_t /*part*/) const
{
    return {{streakGrid(mStreaks, mShape)}, openvdb::CoordBBox::inf()};
}

void StreakTexture::restore(std::uint64_t steps, double seconds, std::shared_ptr<const Domain> /*domain*/,
                            const std::function<std::optional<VdbFile>()>& next)
{
    const std::optional<VdbFile> file = next();
    if (!file) throw InputError("it has no streaks");
    StreakState state = readStreaks(*file);
    mStreaks = std::move(state.streaks);
    mShape = state.shape;
    mHasBegun = true;
    mStep = steps;
    mLastInterval = seconds * mTexture.substeps;
}

} // namespace vdblic
