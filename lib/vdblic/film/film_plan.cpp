#include "vdblic/film/film_plan.h"

#include "vdblic/cast/solid.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/extent.h"
#include "vdblic/core/printable.h"
#include "vdblic/field/domain.h"
#include "vdblic/film/film_cost.h"
#include "vdblic/film/voxel_pixels.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/frame_pattern.h"
#include "vdblic/methods/streaks/streak_shape.h"
#include "vdblic/methods/streaks/streaks.h"
#include "vdblic/render/render_params.h"
#include "vdblic/run/advect_params.h"
#include "vdblic/run/sequence_advice.h"
#include "vdblic/run/texture_run.h"

#include <fmt/format.h>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace vdblic {
namespace {

constexpr double kPace = 10, kLeastPace = 5; // pixels a picture
constexpr double kLeastSeconds = 5, kMostSeconds = 10;
constexpr double kLeastMoves = 4; // voxels a frame, for a flow that moves too little or too far

/// A number that people can type again.
std::string shortNumber(double number)
{
    return fmt::format("{:.2g}", number);
}

Words wordsOfFactors(const std::array<int, 3>& factors)
{
    if (factors[0] == factors[1] && factors[1] == factors[2]) return {fmt::format("{}", factors[0])};
    return {fmt::format("{}", factors[0]), fmt::format("{}", factors[1]), fmt::format("{}", factors[2])};
}

/// Chooses the plan of a film, step by step.
class FilmPlanner {
  public:
    FilmPlanner(const FilmParams& params, const SequenceInfo& info)
        : mParams(params), mInfo(info), mVelocity(*info.velocity), mGrid(*velocityGridOf(info)),
          mStretch(stretchOf(mGrid).value_or(std::array<double, 3>{1, 1, 1})),
          mPixels(pixelsPerVoxel(mGrid, {mStretch[0], mStretch[1], mStretch[2]}, params.pictureSize(), params.view,
                                 has("rim"))),
          mLayer(layerAxis(mGrid.box))
    {
    }

    FilmPlan plan()
    {
        if (!mVelocity.intervalFault.empty()) {
            mPlan.notes.push_back(fmt::format("{}: taking {:.6g} s; the first of the commands takes --dt where it is "
                                              "another",
                                              mVelocity.intervalFault, mVelocity.interval));
        }
        mRun["input"] = {mInfo.pattern};
        takeObserver();
        if (!mParams.periodic.empty()) mRun["periodic"] = mParams.periodic;
        const std::vector<std::int64_t> frames = chooseFrames(chooseMotion());
        const bool isAll = mInfo.missing.empty() && frames == mInfo.frames;
        if (!isAll || !mParams.input.frames.empty()) mRun["frames"] = {frameListText(frames)};
        choosePictures();
        if (has("rim")) chooseGlobe();
        if (mParams.method != FilmMethod::kStreaks) chooseDense();
        if (mParams.method != FilmMethod::kDense) chooseStreaks();
        if (mParams.isPage()) choosePage();
        return std::move(mPlan);
    }

  private:
    void takeObserver()
    {
        ReferenceFrameParams given = mParams.observer, none;
        const Parameters atRest = parametersOf(none);
        for (const Parameter& parameter : parametersOf(given)) {
            const Words words = parameter.get();
            if (words != find(atRest, parameter.key)->get()) mRun[std::string(parameter.key)] = words;
        }
    }

    /// @return pixels that the faster half of the flow moves in a frame
    double chooseMotion()
    {
        const double moves = mVelocity.motion->fasterHalf;
        if (!(moves > 0))
            throw InputError(fmt::format("{}: the flow is at rest; check the grid and the frames", mInfo.pattern));
        if (mInfo.isFrozen && !mParams.isStill()) {
            mMoves = std::clamp(kPace / mPixels, 0.01, 100.0);
            mRun["voxels_per_frame"] = {shortNumber(mMoves)};
        } else if (!makesStreaks(moves) && (moves < kLeastMoves || slowMotion() < moves)) {
            mMoves = moves < kLeastMoves ? kLeastMoves : slowMotion();
            mRun["voxels_per_frame"] = {shortNumber(mMoves)};
            mPlan.notes.push_back(
                fmt::format("the faster half of the flow moves {:.2g} voxels a frame, too {} to follow: "
                            "{} motion; vdblic_info tells more",
                            moves, moves < kLeastMoves ? "little" : "far", moves < kLeastMoves ? "quick" : "slow"));
        } else {
            mMoves = moves;
            if (mParams.isFilm() && !mInfo.isFrozen) quicken();
        }
        return mMoves * mPixels;
    }

    /// Show a slow flow moving faster, up to four times: with the pictures of the least length it would hardly move.
    void quicken()
    {
        constexpr double kMostFactor = 4, kWorthwhile = 1.2, kMostPace = 15;
        const double pictures = mParams.seconds.value_or(kLeastSeconds) * mParams.picturesPerSecond();
        const double pixels = mPixels / std::ceil(std::max(pictures / intervals(), 1.0)); // of a voxel a frame
        const double pace = mMoves * pixels, fastest = mVelocity.motion->largest * pixels;
        const double factor =
            std::min({kLeastPace / pace, kMostPace / fastest, kMostFactor, kLargeDisplacement / mMoves});
        if (factor < kWorthwhile) return;
        mMoves *= factor;
        mRun["voxels_per_frame"] = {shortNumber(mMoves)};
        mPlan.notes.push_back(fmt::format("the flow moves {:.2g} pixels a picture, too little to see: its motion is "
                                          "shown {:.2g} times as fast as the frames change",
                                          pace, factor));
    }

    /// The number of intervals between frames.
    [[nodiscard]] double intervals() const { return double(std::max<std::size_t>(mInfo.frames.size(), 2) - 1); }

    /// The voxels a frame with which a film of all frames has the right pace; of others, that streaks can follow.
    [[nodiscard]] double slowMotion() const
    {
        constexpr double kMostMoves = 12;
        if (!mParams.isFilm()) return kMostMoves;
        const double pictures = mParams.seconds.value_or(kMostSeconds) * mParams.picturesPerSecond();
        return std::max(kPace * pictures / intervals() / mPixels, kLeastMoves);
    }

    /// Choose frames, substeps and the number of pictures. @param pace as chooseMotion() returns it
    std::vector<std::int64_t> chooseFrames(double pace)
    {
        std::vector<std::int64_t> frames = mInfo.frames;
        if (mParams.isStill()) return {frames[frames.size() / 2]};
        const double perSecond = mParams.picturesPerSecond();
        const auto pictures = [&](double seconds) {
            return std::size_t(std::max(std::round(seconds * perSecond), 1.0));
        };
        constexpr std::size_t kOfPage = 48; // of a flow that stays as it is
        if (mInfo.isFrozen) {
            mPlan.textures = mPlan.pictures =
                mParams.isPage() ? kOfPage : pictures(mParams.seconds.value_or(kLeastSeconds));
            mRun["steady_frames"] = {fmt::format("{}", mPlan.textures)};
            return frames;
        }
        if (mParams.isPage()) { // shows all times between frames
            mPlan.textures = frames.size();
            return frames;
        }
        constexpr std::size_t kMostSubsteps = TextureParams::kMostSubsteps;
        const std::size_t intervals = frames.size() - 1;
        auto substeps = std::size_t(std::clamp(std::ceil(pace / kPace), 1.0, double(kMostSubsteps)));
        const std::size_t least = pictures(mParams.seconds.value_or(kLeastSeconds)),
                          most = pictures(mParams.seconds.value_or(kMostSeconds));
        const std::size_t forLeast = (least + intervals - 2) / intervals; // substeps for so many pictures
        if (mParams.seconds && forLeast > kMostSubsteps) {
            throw ParameterError(fmt::format("`seconds` {} is too long: {} frames make a film of {:.3g} s at most",
                                             *mParams.seconds, frames.size(),
                                             double(intervals * kMostSubsteps + 1) / perSecond));
        }
        substeps = std::min(std::max({substeps, forLeast, std::size_t(1)}), kMostSubsteps);
        const std::size_t used = std::min(intervals, (most + substeps - 2) / substeps);
        mPlan.textures = used * substeps + 1;
        mPlan.pictures = std::min(mPlan.textures, most);
        if (used < intervals) {
            mPlan.notes.push_back(fmt::format("{:.3g} s hold frames {} to {} of {}; give more `seconds` for more",
                                              double(mPlan.pictures) / perSecond, frames[0], frames[used],
                                              frames.size()));
            frames.resize(used + 1);
        }
        if (substeps > 1) mRun["substeps"] = {fmt::format("{}", substeps)};
        mPlan.notes.push_back(
            fmt::format("{} pictures, {:.3g} s; the faster half of the flow moves {:.2g} pixels a picture",
                        mPlan.pictures, double(mPlan.pictures) / perSecond, pace / double(substeps)));
        const bool isDense = frames.back() - frames.front() == std::int64_t(used);
        if (mPlan.pictures < mPlan.textures && isDense) {
            mPlan.render["frames"] = {
                fmt::format("{}-{}", frames.front(), frames.front() + std::int64_t(mPlan.pictures) - 1)};
        } else {
            mPlan.pictures = mPlan.textures;
        }
        return frames;
    }

    void chooseStreaks()
    {
        // Pixels, of a picture that is no preview. Of streaks in vortices alone few are seen.
        constexpr double kSpacing = 24, kInVortices = 14, kOnGlobe = 18, kVoxel = 2;
        const double factor = mParams.preview ? 0.5 : 1, tail = 6;
        const double least = mVelocity.streaks ? double(mVelocity.streaks->spacing[0]) : 1;
        const double pixels = followsVortices() ? kInVortices : has("rim") ? kOnGlobe : kSpacing;
        const double sparser = mParams.method == FilmMethod::kBoth && !followsVortices() ? 2 : 1; // to see the texture
        const double spacing = sparser * std::clamp(pixels * factor / mPixels, least, 2 * least);
        StreakParams streaks;
        streaks.spacing.emplace();
        streaks.spacing->fill(std::stof(shortNumber(spacing)));
        Refinement refinement;
        refinement.isGiven = true;
        refinement.factors = refinedBy(std::round(mPixels / kVoxel));
        const double leaves = 1.5 * double(mVelocity.voxels) / double(Domain::kLeafVoxels);
        const StreakShape shape = streakShape(streaks, refinement, mVelocity.voxels, mGrid.box, mMoves);
        const StreakCost cost = streakCost(shape, StreakForm::kLines, double(mVelocity.voxels), leaves, mGrid.box);
        Given run = mRun;
        run["method"] = {"streaks"};
        run["draw"] = {"lines"};
        mPlan.render["samples"] = {"2"};
        run["spacing"] = {shortNumber(spacing)};
        constexpr double kJoined = 1.5; // frames: pages and pictures between frames join the tails of frames
        const double frames = std::clamp(tail * spacing / mMoves, mParams.isPage() ? kJoined : 0, 24.0);
        run["tail"] = {shortNumber(frames)};
        run["refine"] = wordsOfFactors(refinement.factors);
        if (followsVortices()) run["derived"] = {"q"};
        if (has("rim")) run["emit"] = {firstFile() + ":rim"};
        if (mParams.method == FilmMethod::kStreaks && frames >= kJoined && mParams.observer.rotation == 0)
            moveSubsteps(run);
        mPlan.runs.push_back(std::move(run));
        addStreakCost(mPlan, cost, picturePixels());
    }

    /// Draw the pictures between frames from the frames' lines.
    void moveSubsteps(Given& run)
    {
        const auto substeps = run.extract("substeps");
        if (substeps.empty()) return;
        mPlan.textures = (mPlan.textures - 1) / std::stoul(substeps.mapped().front()) + 1;
        mPlan.render["substeps"] = substeps.mapped();
    }

    [[nodiscard]] double picturePixels() const { return double(mParams.pictureSize().x) * mParams.pictureSize().y; }

    void chooseDense()
    {
        constexpr double kVoxel = 3, kMostVoxels = 8e6;
        std::array<int, 3> factors = refinedBy(std::round(mPixels / kVoxel));
        const auto voxels = [&] { return double(mVelocity.voxels) * factors[0] * factors[1] * factors[2]; };
        while (voxels() > kMostVoxels && coarsen(factors)) {
        }
        mPlan.textureVoxels = voxels();
        addDenseCost(mPlan, picturePixels(), mParams.method == FilmMethod::kBoth);
        Given& run = mPlan.runs.emplace_back(mRun);
        run["refine"] = wordsOfFactors(factors);
        if (mPlan.render.contains("opacity_by")) run["derived"] = {"q"};
    }

    /// Whether opacity by Q shows more than opacity by speed: most of the flow is fast, so that the outside would hide
    /// the inside, and there are vortices. In a flat domain or a shell Q follows the shear between its layers.
    [[nodiscard]] bool hidesVortices() const
    {
        constexpr double kMostlyFast = 0.7, kRotation = 0.01;
        const bool isFlat = mLayer >= 0 || mStretch != std::array<double, 3>{1, 1, 1};
        const MotionInfo& motion = *mVelocity.motion;
        return !isFlat && !has("rim") && motion.mean > kMostlyFast * motion.fasterHalf && motion.rotation > kRotation;
    }

    [[nodiscard]] bool followsVortices() const
    {
        return mParams.look == "vortex" || (mParams.look.empty() && hidesVortices());
    }

    /// Whether the flow leaves a body, or the ground, out of its box.
    [[nodiscard]] bool flowsAroundSolid() const
    {
        const double box = voxelsOf(mGrid.box);
        // To an observer who turns, the box of the flow's voxels has empty corners.
        return mLayer < 0 && mParams.observer.rotation == 0 &&
               double(mVelocity.voxels)<box&& double(mVelocity.voxels)>(1 - kMostSolid) * box;
    }

    /// A factor for each axis along which there are several voxels.
    [[nodiscard]] std::array<int, 3> refinedBy(double factor) const
    {
        std::array<int, 3> factors{};
        factors.fill(int(std::clamp(factor, 1.0, double(Refinement::kMost))));
        if (mLayer >= 0) factors[std::size_t(mLayer)] = 1;
        return factors;
    }

    /// @return whether it could be
    static bool coarsen(std::array<int, 3>& factors)
    {
        const int before = factors[0] + factors[1] + factors[2];
        for (int& factor : factors)
            factor = std::max(factor - 1, 1);
        return factors[0] + factors[1] + factors[2] < before;
    }

    void choosePictures()
    {
        Given& render = mPlan.render;
        if (!mParams.look.empty()) render["look"] = {mParams.look};
        // A texture around lines shows the flow around the vortices that lines show.
        const bool isAround = mParams.method == FilmMethod::kBoth && mParams.look.empty();
        if (followsVortices() && !isAround) render["opacity_by"] = {"q"};
        const glm::ivec2 size = mParams.pictureSize();
        render["size"] = {fmt::format("{}", size.x), fmt::format("{}", size.y)};
        if (mStretch != std::array<double, 3>{1, 1, 1}) {
            for (const double stretch : mStretch)
                render["stretch"].push_back(fmt::format("{}", stretch));
        }
        if (mParams.view != ViewSide::kThreeQuarter) render["view"] = {std::string(nameOf(mParams.view))};
        if (mParams.angles) render["angles"] = WordsOf<glm::dvec2>::write(*mParams.angles);
        if (!mParams.solid.empty()) {
            render["solid"] = {mParams.solid};
        } else if (flowsAroundSolid()) {
            render["solid"] = {"domain"};
        }
        if (render.contains("solid")) render["solid_color"] = WordsOf<glm::dvec3>::write(mParams.solidColor);
        if (!mParams.plain)
            render["annotate"] = {mInfo.frames.size() > 1 ? "colorbar,time,scalebar" : "colorbar,scalebar"};
        if (mParams.isStill()) {
            render["output"] = {mParams.output};
            return;
        }
        render["film"] = {mParams.output};
        render["fps"] = {fmt::format("{}", mParams.picturesPerSecond())};
        if (mParams.orbit != 0) render["orbit"] = {fmt::format("{}", mParams.orbit)};
    }

    /// Use the grids of vdblic_import --globe and of the flow rossby: streaks begin within the rims of the shell, the
    /// Earth is solid, and colour follows the true speed.
    void chooseGlobe()
    {
        if (has("speed")) {
            mRun["carry"] = {"speed"};
            mPlan.render["color_by"] = {"speed"};
        }
        if (mParams.solid.empty() && has("solid")) {
            mPlan.render["solid"] = {firstFile() + ":solid"};
            mPlan.render["solid_color"] = WordsOf<glm::dvec3>::write(mParams.solidColor);
            mPlan.render["earth"] = {"true"};
        }
    }

    /// Lines in place of pictures; vdblic_export chooses what they look like.
    void choosePage()
    {
        mPlan.page = {"-o", mParams.output};
        const auto solid = mPlan.render.find("solid");
        if (solid != mPlan.render.end()) mPlan.page.insert(mPlan.page.end(), {"--solid", solid->second.front()});
    }

    [[nodiscard]] std::string firstFile() const
    {
        return FramePattern(mInfo.pattern).path(mInfo.frames.front()).string();
    }

    [[nodiscard]] bool has(std::string_view name) const
    {
        return std::any_of(mInfo.grids.begin(), mInfo.grids.end(), [&](const GridInfo& grid) {
            return grid.name == name && grid.files == mInfo.frames.size();
        });
    }

    const FilmParams& mParams;
    const SequenceInfo& mInfo;
    const VelocityInfo& mVelocity;
    const GridInfo& mGrid;
    std::array<double, 3> mStretch;
    double mPixels, mMoves = 0; // that a voxel spans; voxels that the faster half moves in a frame
    int mLayer;
    Given mRun; // what runs of vdblic_advect have in common
    FilmPlan mPlan;
};

} // namespace

FilmPlan planFilm(const FilmParams& params, const SequenceInfo& info)
{
    if (!info.damaged.empty()) throw InputError(info.damaged.front());
    const GridInfo* const grid = info.velocity ? velocityGridOf(info) : nullptr;
    if (!grid || !info.velocity->motion) {
        throw InputError(fmt::format("{}: holds no velocity, a grid of vectors or three of scalars; vdblic_info tells "
                                     "what is in it",
                                     info.pattern));
    }
    if (grid->values && !grid->values->isFinite())
        throw InputError(fmt::format("{}: no value of grid '{}' is finite", info.pattern, grid->name));
    if (grid->box.empty() || info.velocity->voxels == 0)
        throw InputError(fmt::format("{}: grid '{}' has no active voxel", info.pattern, grid->name));
    return FilmPlanner(params, info).plan();
}

} // namespace vdblic
