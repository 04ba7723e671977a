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

/// Common data of a step's tiles.
struct ScatterScene {
    const TextureParams& params;
    std::uint64_t step;
    float slopeScale;
    const VelocityField& field;
    const LeafValues<std::int32_t>& input;
    Accumulator& accumulator;
    const Domain& next;
    std::vector<ParticleBins>& arriving; ///< each tile takes out its own particles
};

/// Scatters one tile after another with the dynamic seeding controller (Liu & Moorhead 2004, section 2.2).
///
/// A *tile* is one leaf of the domain as the controller's unit of work, known by the leaf's number.
///
/// With substeps a tile releases seeds in one substep of each frame (isReleaseTurn()); in the others its particles only
/// advance and deposit. The rest of this text is about a step that releases.
///
/// A voxel is *open* until a seed is released in it during this step, then *closed*. First the tile's particles of
/// earlier steps advance: one that starts in an open voxel, or passes one within the release window, closes it and
/// collects its value (pathline reuse, and pathline copying for every further voxel). Then each voxel that is still
/// open, in scan order, releases a particle, which likewise collects the open voxels on its path.
///
/// A particle whose own voxel is closed at its turn is blocked. The type of its load decides what happens to it, the
/// order of turns, and whether particles collect values at all.
///
/// One object serves one thread; it writes only to itself, the accumulator and the arriving bins of its tile.
/// @tparam Carried load of a particle: FadingValues, ValueWindow or SingleValue
template<typename Carried>
class TileScatter {
  public:
    explicit TileScatter(const ScatterScene& scene);

    /// @param shared whether other threads may add to the same voxels of the accumulator meanwhile
    void run(std::size_t leaf, bool shared);

    [[nodiscard]] const ScatterStats& stats() const { return mStats; }
    /// The particles that continue.
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
    const std::size_t mWordCount; // per particle
    const bool mIsPeriodic;       // whether the next step's domain is

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
    alignas(32) int mEnds[kLanes] = {}; // codes in mNextWindow of the paths' end voxels
    Particle mParticle{};
    std::vector<std::uint32_t> mWords;
    std::uint32_t mTaken = 0; // values collected in this step

    ParticleBins mLeaving;
    ScatterStats mStats;
};

} // namespace vdblic
