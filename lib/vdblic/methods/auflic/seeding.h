#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/pathline.h"
#include "vdblic/lic/scatter_stats.h"
#include "vdblic/methods/auflic/accumulator.h"
#include "vdblic/methods/auflic/particle_bins.h"
#include "vdblic/methods/texture_params.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// Everything the tiles of a step share.
struct ScatterScene {
    const TextureParams& params;
    std::uint64_t step;
    float slopeScale;
    const VelocityField& field;
    const LeafValues<std::int32_t>& input;
    Accumulator& accumulator;
    const Domain& next;
    std::vector<ParticleBins>& arriving; ///< each tile takes its own particles out of them
};

/// Scatters one tile after another with the dynamic seeding controller (Liu & Moorhead 2004, section 2.2).
///
/// A *tile* is one leaf of the domain as the controller's unit of work, known by the leaf's number.
///
/// With substeps a tile releases seeds in one substep of each frame (isReleaseTurn()); in the others its particles only
/// advance and deposit. What follows is about a step that releases.
///
/// A voxel is *open* until a seed has been released in it during this step, then *closed*. First the tile's particles
/// of earlier steps are advanced: a particle that starts in an open voxel, or passes one within the release window,
/// closes it and takes up its value (pathline reuse, and pathline copying for every further voxel). Then each voxel
/// that is still open, in scan order, releases a particle of its own, which likewise takes up the open voxels it
/// passes.
///
/// A particle whose own voxel is closed when its turn comes is blocked. What becomes of it, in which order the
/// particles have their turns, and whether they take up values at all depends on what they carry.
///
/// One object serves one thread; it writes to nothing outside itself but the accumulator and the arriving bins of its
/// tile.
/// @tparam Carried what a particle carries: FadingValues, ValueWindow or SingleValue
template<typename Carried>
class TileScatter {
  public:
    explicit TileScatter(const ScatterScene& scene);

    /// @param shared whether other threads may add to the same voxels of the accumulator at the same time
    void run(std::size_t leaf, bool shared);

    [[nodiscard]] const ScatterStats& stats() const { return mStats; }
    /// The particles that live on.
    [[nodiscard]] ParticleBins& leaving() { return mLeaving; }

  private:
    /// A particle's turn, in ascending order.
    struct Turn {
        std::uint64_t order;
        std::uint32_t particle; // its index in mParticles
        std::uint32_t voxel;    // its offset in the leaf
    };

    void takeArriving();
    void join();
    void sortTurns();
    template<bool kShared>
    void runTile();
    template<bool kShared>
    void advanceLive();
    template<bool kShared>
    void releaseNew();
    void trace();
    template<bool kShared>
    bool scatterPath(int lane, bool mayTakeUp);
    void keep(int lane);

    template<typename C>
    friend void runShared(TileScatter<C>& self);
    template<typename C>
    friend void runAlone(TileScatter<C>& self);

    const ScatterScene& mScene;
    const Domain& mDomain;
    const Carried mCarried;
    const std::size_t mWordCount; // of each particle

    // The tile being computed.
    std::size_t mLeaf = 0;
    bool mReleases = false;          // whether seeds are released in this step
    LeafWindow mWindow, mNextWindow; // in the domain, and the next step's
    Bricks::Window mFieldWindow;
    std::array<std::int64_t*, LeafWindow::kElsewhere> mTarget{}; // the accumulator's leaf in each slot of the window
    const std::int32_t* mInput = nullptr;
    Domain::Mask mOpen;
    std::vector<Particle> mParticles;
    std::vector<std::uint32_t> mParticleWords;
    std::vector<Turn> mTurns, mMerged;
    std::vector<std::size_t> mRuns;

    // The particles being advanced together, and the one of them being scattered.
    PathBatch mBatch;
    PathSamples mSamples;
    alignas(32) int mEnds[kLanes] = {}; // codes of the voxels in mNextWindow that the paths end in
    Particle mParticle{};
    std::vector<std::uint32_t> mWords;
    std::uint32_t mTaken = 0; // values that it took up in this step

    ParticleBins mLeaving;
    ScatterStats mStats;
};

} // namespace vdblic
