#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_window.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/accumulator.h"
#include "vdblic/lic/particle_bins.h"
#include "vdblic/lic/pathline.h"
#include "vdblic/lic/scatter_params.h"
#include "vdblic/lic/scatter_stats.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic {

/// Which of a particle's Generation words a step adds to, and which values end with the step. A word holds the values
/// of one frame's substeps; a particle's frames begin at the substep of its release.
struct GenerationClock {
    std::uint32_t current; ///< index of this step's word
    std::uint32_t before;  ///< index of the word of the step before
    std::uint32_t oldest;  ///< index of the word whose values end next
    bool endsFrame;        ///< the oldest values end with this step
};

/// Everything the tiles of a step share.
struct ScatterScene {
    const ScatterParams& params;
    std::uint64_t step;
    float slopeScale;
    const VelocityField& field;
    const LeafValues<std::int32_t>& input;
    const Accumulator& accumulator;
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
/// A particle whose own voxel is closed when its turn comes is blocked. With ScatterParams::history the particles
/// released last go first, and a blocked particle ends; of several that begin the step in one voxel, the first takes
/// over the values of the others. Without history the oldest go first; a particle that took up nothing in a whole step
/// takes up no more, and ends when its values have expired. With UFLIC every voxel releases a particle, and no particle
/// takes up a second value.
///
/// One object serves one thread; it writes to nothing outside itself but the accumulator and the arriving bins of its
/// tile.
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

    [[nodiscard]] const GenerationClock& clockOf(const Particle& particle) const;
    void takeArriving();
    void coalesce();
    void sortTurns();
    template<bool kShared>
    void runTile();
    template<bool kShared>
    void advanceLive();
    template<bool kShared>
    void releaseNew();
    void trace();
    [[nodiscard]] bool wasBlocked() const;
    template<bool kShared>
    bool scatterPath(int lane, bool mayTakeUp);
    void keep(int lane);

    friend void runShared(TileScatter& self);
    friend void runAlone(TileScatter& self);

    const ScatterScene& mScene;
    const Domain& mDomain;
    const bool mAuflic, mHistory;
    const std::size_t mGenerationCount;
    std::vector<GenerationClock> mClocks; // by the substep of release

    // The tile being computed.
    std::size_t mLeaf = 0;
    bool mReleases = false;          // whether seeds are released in this step
    LeafWindow mWindow, mNextWindow; // in the domain, and the next step's
    Bricks::Window mFieldWindow;
    std::array<std::int64_t*, LeafWindow::kElsewhere> mTarget{}; // the accumulator's leaf in each slot of the window
    const std::int32_t* mInput = nullptr;
    Domain::Mask mOpen;
    std::vector<Particle> mParticles;
    std::vector<std::uint32_t> mParticleGenerations;
    std::vector<Turn> mTurns, mMerged;
    std::vector<std::size_t> mRuns;

    // The particles being advanced together, and the one of them being scattered.
    PathBatch mBatch;
    PathSamples mSamples;
    alignas(32) int mEnds[kLanes] = {}; // codes of the voxels in mNextWindow that the paths end in
    Particle mParticle{};
    std::vector<std::uint32_t> mGenerations;
    std::uint32_t mTaken = 0; // values that it took up in this step

    ParticleBins mLeaving;
    ScatterStats mStats;
};

} // namespace vdblic
