#pragma once

#include "vdblic/lic/noise_field.h"
#include "vdblic/lic/pathline.h"
#include "vdblic/lic/scatter.h"

#include <vector>

namespace vdblic::bench {

/// AUFLIC in the order of work of Liu & Moorhead 2004: scattering process after scattering process, each of which
/// carries its seeds through their whole life span into a ring of buckets, along pathlines that are kept whole for the
/// process after it. The integrator and the choice of seeds are ours, but one pathline is at work at a time, as that
/// order has it. On one thread.
class ScapAuflic {
  public:
    ScapAuflic(int lifeSpan, float releaseWindow, const NoiseField& noise);

    /// @param fields the velocity over each step, as many as the life span beyond k, all on one domain
    LeafValues<float> scatteringProcess(std::size_t k, const std::vector<VelocityField>& fields);

    /// Of the last process.
    [[nodiscard]] const ScatterStats& stats() const { return mStats; }

    /// A pathline from the step at work on, and the voxels (leaf · 512 + offset) it leads through in each.
    struct Path {
        struct Step {
            std::uint32_t start = 0, early = 0; ///< the voxel it begins in; voxels within the release window
            std::vector<std::uint32_t> voxels;
        };
        std::uint64_t id = 0;
        Float4 position{}, slope{}; ///< at the end of the last step
        bool ended = false;         ///< left the domain
        std::vector<Step> steps;
    };

  private:
    void seedTile(std::size_t k, const std::vector<VelocityField>& fields, std::size_t leaf);
    bool releaseAlong(std::size_t k, const std::vector<VelocityField>& fields, std::size_t leaf, Path& path);
    void extend(const VelocityField& field, Path& path);

    ScatterParams mParams;
    NoiseField mNoise;
    std::vector<LeafValues<std::int64_t>> mBuckets;
    LeafValues<std::int32_t> mInput;
    std::vector<std::vector<Path>> mSaved, mNext; // by tile
    std::vector<std::uint64_t> mFirstRank;
    Domain::Mask mOpen;
    PathBatch mBatch;
    PathSamples mSamples;
    ScatterStats mStats;
};

} // namespace vdblic::bench
