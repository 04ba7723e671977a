#pragma once

#include "vdblic/lic/pathline.h"
#include "vdblic/methods/auflic/accumulator.h"
#include "vdblic/methods/auflic/scatter.h"
#include "vdblic/noise/noise_field.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdblic::bench {

/// AUFLIC in the order of work of Liu & Moorhead 2004: one scattering process after the other. Each process carries its
/// seeds through their whole life span into a ring of buckets, along pathlines that are kept whole for the next
/// process. Integrator and choice of seeds are those of the library, but pathlines are advanced one at a time, as that
/// order requires. On one thread.
class ScapAuflic {
  public:
    ScapAuflic(int lifeSpan, float releaseWindow, NoiseField noise);

    /// @param fields the velocity over each step, as many as the life span beyond k, all on one domain
    LeafValues<float> scatteringProcess(std::size_t k, std::vector<VelocityField>& fields);

    /// Of the last process.
    [[nodiscard]] const ScatterStats& stats() const { return mStats; }

    /// A pathline from the current step on, and the voxels (leaf · 512 + offset) it passes in each step.
    struct Path {
        struct Step {
            std::uint32_t start = 0, early = 0; ///< first voxel; number of voxels within the release window
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

    TextureParams mParams;
    NoiseField mNoise;
    std::vector<Accumulator> mBuckets;
    LeafValues<std::int32_t> mInput;
    std::vector<std::vector<Path>> mSaved, mNext; // by tile
    std::vector<std::uint64_t> mFirstRank;
    Domain::Mask mOpen;
    PathBatch mBatch;
    PathSamples mSamples;
    ScatterStats mStats;
};

} // namespace vdblic::bench
