#pragma once

#include "vdblic/field/vector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <forward_list>
#include <span>
#include <vector>

namespace vdblic {

/// The moving end of a pathline. Its words, if any, are stored apart.
struct Particle {
    static constexpr int kVoxelBits = 43;                              // of the id
    static constexpr std::uint64_t kMostHits = std::uint64_t(1) << 18; // of a particle between steps

    std::array<float, 3> position; ///< index space, voxel centres at integers
    std::array<float, 3> slope;    ///< velocity there, voxels per time step
    std::uint64_t alive;           ///< Hits of the values within their life span
    std::uint64_t id;              ///< step of release << kVoxelBits | number of the release voxel in the domain
};

/// Particles moved by one thread, by their current tile.
///
/// Chunks are reused as soon as they have been read: arriving and leaving particles together take the memory of one
/// set. Not thread-safe, but for take() on distinct tiles with distinct users.
class ParticleBins {
  public:
    /// @param words per particle beside its Hits
    ParticleBins(std::size_t tiles, std::size_t words) : mWords(words), mBins(tiles) {}
    ParticleBins(ParticleBins&&) = default; // chunks cannot be copied
    ParticleBins& operator=(ParticleBins&&) = default;

    VDBLIC_INLINE void add(std::size_t tile, const Particle& particle, const std::uint32_t* words)
    {
        Bin& bin = mBins[tile];
        const std::size_t place = bin.count % kCapacity;
        if (place == 0) grow(bin);
        bin.chunks.front()[place] = particle;
        ++bin.count;
        if (mWords > 0) bin.words.insert(bin.words.end(), words, words + mWords);
        for (std::size_t axis = 0; axis < 3; ++axis)
            mLargestSlope[axis] = std::max(mLargestSlope[axis], std::abs(particle.slope[axis]));
    }

    /// The number of words per particle beside its Hits.
    [[nodiscard]] std::size_t words() const { return mWords; }

    /// The largest magnitude of a particle's slope so far, along each axis [voxels per step].
    [[nodiscard]] const std::array<float, 3>& largestSlope() const { return mLargestSlope; }

    /// Append a tile's particles, in any order, and their words; empties the bin.
    /// @param user receives the chunks, for use by its add()
    void take(std::size_t tile, std::vector<Particle>& particles, std::vector<std::uint32_t>& words,
              ParticleBins& user);

    /// Free received chunks that are unused.
    void freeSpare() { mSpare.clear(); }

    /// Visit a tile's particles: visit(particle, words).
    template<typename Visit>
    void forEach(std::size_t tile, const Visit& visit) const
    {
        forEachChunk(mBins[tile], [&](std::span<const Particle> particles, const std::uint32_t* words) {
            for (const Particle& particle : particles) {
                visit(particle, words);
                words += mWords;
            }
        });
    }

  private:
    static constexpr std::size_t kCapacity = 16; // of a chunk; the last one of a bin is half empty
    using Chunks = std::forward_list<std::array<Particle, kCapacity>>;
    struct Bin {
        Chunks chunks; // full, except for the first
        std::size_t count = 0;
        std::vector<std::uint32_t> words; // of all particles, in order of addition
    };

    /// Visit a bin's chunks: visit(particles, their words).
    template<typename Visit>
    void forEachChunk(const Bin& bin, const Visit& visit) const
    {
        std::size_t end = bin.count;
        for (const auto& chunk : bin.chunks) {
            const std::size_t begin = (end - 1) / kCapacity * kCapacity;
            visit(std::span(chunk).first(end - begin), bin.words.data() + begin * mWords);
            end = begin;
        }
    }

    /// Insert an empty chunk in front.
    void grow(Bin& bin);

    std::size_t mWords = 0;
    std::vector<Bin> mBins;
    Chunks mSpare;
    std::array<float, 3> mLargestSlope{};
};

} // namespace vdblic
