#pragma once

#include "vdblic/lic/scatter.h"

namespace vdblic {

/// What the tiles of a step work on.
struct ScatterScene {
    const ScatterParams& params;
    std::uint64_t step;
    float slopeScale;
    const VelocityField& field;
    const LeafValues<std::int32_t>& input;
    const LeafValues<std::int64_t>& accumulator;
    const Domain& next;
    std::vector<ParticleBins>& arriving;  ///< each tile takes its own particles out of them
    std::vector<std::uint64_t> firstRank; ///< of each leaf: its first voxel's place in the domain's scan order
};

/// Scatters one tile after another with the dynamic seeding controller (Liu & Moorhead 2004, section 2.2).
///
/// A voxel is *open* until a seed has been released in it during this step, then *closed*. First the tile's
/// particles of earlier steps are advanced: one that starts in an open voxel, or passes one within the
/// release window, closes it and takes up its value (pathline reuse, and pathline copying for every further voxel).
/// Then each voxel that is still open, in scan order, releases a particle of its own, which likewise takes up the open
/// voxels it passes.
///
/// A particle whose own voxel is closed when its turn comes is blocked. With ScatterParams::history those released last
/// go first, and a blocked one ends there; of several that begin the step in one voxel the first takes over the values
/// of the others. Without, the oldest go first, one that took up nothing in a whole step takes up no more, and ends
/// when the values it carries have expired. With UFLIC every voxel releases a particle, and none takes up a second
/// value.
///
/// One object serves one thread; what it writes is its own but for the accumulator.
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
        std::uint32_t particle; // its place in mParticles
        std::uint32_t voxel;    // that it is in
    };

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
    template<bool kShared>
    bool scatterPath(int lane, bool mayTakeUp);
    void keep(int lane);

    friend void runShared(TileScatter& self);
    friend void runAlone(TileScatter& self);

    const ScatterScene& mScene;
    const Domain& mDomain;
    const bool mAuflic, mHistory;
    const std::size_t mGenerationCount;

    // The tile at work.
    std::size_t mLeaf = 0;
    LeafWindow mWindow, mNextWindow;
    std::array<std::int64_t*, LeafWindow::kElsewhere> mTarget{}; // the accumulator's leaves in the window
    const std::int32_t* mInput = nullptr;
    Domain::Mask mOpen;
    std::vector<Particle> mParticles;
    std::vector<std::uint32_t> mParticleGenerations;
    std::vector<Turn> mTurns, mMerged;
    std::vector<std::size_t> mRuns;

    // The particles at work, and the one among them.
    PathBatch mBatch;
    PathSamples mSamples;
    Particle mParticle{};
    std::vector<std::uint32_t> mGenerations;

    ParticleBins mLeaving;
    ScatterStats mStats;
};

} // namespace vdblic
