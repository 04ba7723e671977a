#pragma once

#include "vdblic/lic/scatter.h"

namespace vdblic {

/// One tile's share of a step.
struct Tile {
    int leaf;
    const ParticleStore& particles; ///< sorted; the tile's are [begin, end)
    std::size_t begin, end;
    std::uint64_t firstId; ///< of the tile's first voxel in scan order
};

/// Scatters one tile after another with the dynamic seeding controller (Liu & Moorhead 2004, section 2.2).
///
/// A voxel is *open* until a seed has been released in it during this step, then *closed*. First the tile's
/// particles of earlier steps are advanced, oldest first: one that starts in an open voxel, or passes one within the
/// release window, closes it and takes up its value (pathline reuse, and pathline copying for every further voxel).
/// Then each voxel that is still open, in scan order, releases a particle of its own, which likewise takes up the open
/// voxels it passes. A particle that took up nothing in a step is blocked: it takes up no more and ends when the values
/// it carries have expired. With UFLIC every voxel releases a particle, and none takes up a second value.
///
/// One object serves one thread; what it writes is its own but for the accumulator.
class TileScatter {
  public:
    TileScatter(const VelocityField& field, const LeafValues<std::int32_t>& input,
                const LeafValues<std::int64_t>& accumulator, const ScatterParams& params, std::uint64_t step);

    /// @param shared whether other threads add to the accumulator at the same time
    void run(const Tile& tile, bool shared);

    [[nodiscard]] const ScatterStats& stats() const { return mStats; }
    /// The particles that live on.
    [[nodiscard]] ParticleStore& moved() { return mMoved; }

  private:
    template<bool kShared>
    void runTile(const Tile& tile);
    template<bool kShared>
    void advanceLive(const Tile& tile);
    template<bool kShared>
    void releaseNew(const Tile& tile);
    template<bool kShared>
    bool scatterPath(const std::vector<Segment>& path, bool mayTakeUp);
    void keep(const PathBatch& batch, std::size_t lane);

    friend void runShared(TileScatter& self, const Tile& tile);
    friend void runAlone(TileScatter& self, const Tile& tile);

    const VelocityField* mField;
    const Domain* mDomain;
    const LeafValues<std::int32_t>* mInput;
    const LeafValues<std::int64_t>* mAccumulator;
    const ScatterParams* mParams;
    std::uint64_t mStep;

    // The tile at work.
    int mLeaf = -1;
    const std::int32_t* mTileInput = nullptr;
    Domain::Mask mOpen;

    // The particle at work.
    Particle mParticle{};
    std::vector<std::uint32_t> mGenerations;

    PathBatch mBatch;
    ParticleStore mMoved;
    ScatterStats mStats;
};

} // namespace vdblic
