#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdblic {

/// A pathline in the making: where it is now. The values it carries stand beside it, a word for each of its
/// generations.
struct Particle {
    static constexpr int kRankBits = 40; // of the id

    std::array<float, 3> position; ///< index space, voxel centres at integers
    std::array<float, 3> slope;    ///< velocity there, voxels per time step
    std::uint64_t alive;           ///< Hits of the values that are still within their life span
    std::uint64_t id; ///< step of release << kRankBits | rank of the release voxel in the domain's scan order
};

/// Particles of one thread, by the tile they are in.
///
/// Kept in chunks, each of which is used again as soon as it was read: the particles that come and those that go take
/// the room of one. Not thread-safe.
class ParticleBins {
  public:
    /// @param generations words that each particle carries
    ParticleBins(std::size_t tiles, std::size_t generations) : mGenerations(generations), mBins(tiles) {}
    ParticleBins(ParticleBins&&) = default; // no copies, as the bins' chunks have none
    ParticleBins& operator=(ParticleBins&&) = default;

    void add(std::size_t tile, const Particle& particle, const std::uint32_t* generations);

    /// Words that each particle carries.
    [[nodiscard]] std::size_t generations() const { return mGenerations; }

    /// The largest amount of any particle's slope that was added, along each axis.
    [[nodiscard]] const std::array<float, 3>& largestSlope() const { return mLargestSlope; }

    /// Append a tile's particles, in the order they were added, and their generations; the bin is empty then.
    /// @param user takes the memory, for what will be added to it
    void take(std::size_t tile, std::vector<Particle>& particles, std::vector<std::uint32_t>& generations,
              ParticleBins& user);

    /// Free memory that was taken and not needed.
    void freeSpare() { Bin().swap(mSpare); }

    /// Visit a tile's particles: visit(particle, generations).
    template<typename Visit>
    void forEach(std::size_t tile, const Visit& visit) const
    {
        for (const auto& chunk : mBins[tile]) {
            for (std::size_t i = 0; i < chunk->count; ++i)
                visit(chunk->particles[i], chunk->generations.get() + i * mGenerations);
        }
    }

  private:
    struct Chunk {
        static constexpr std::size_t kCapacity = 32;

        std::size_t count = 0;
        std::unique_ptr<std::uint32_t[]> generations;
        std::array<Particle, kCapacity> particles;
    };
    using Bin = std::vector<std::unique_ptr<Chunk>>;

    std::size_t mGenerations = 0;
    std::vector<Bin> mBins;
    Bin mSpare; // chunks to be used again
    std::array<float, 3> mLargestSlope{};
};

} // namespace vdblic
