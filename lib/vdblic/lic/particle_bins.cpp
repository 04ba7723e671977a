#include "vdblic/lic/particle_bins.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdblic {

void ParticleBins::add(std::size_t tile, const Particle& particle, const std::uint32_t* generations)
{
    Bin& bin = mBins[tile];
    if (bin.empty() || bin.back()->count == Chunk::kCapacity) {
        if (mSpare.empty()) {
            bin.emplace_back(new Chunk); // not make_unique: it would zero the particles
            bin.back()->generations.reset(new std::uint32_t[Chunk::kCapacity * mGenerations]);
        } else {
            bin.push_back(std::move(mSpare.back()));
            mSpare.pop_back();
        }
    }
    Chunk& chunk = *bin.back();
    chunk.particles[chunk.count] = particle;
    std::copy_n(generations, mGenerations, chunk.generations.get() + chunk.count * mGenerations);
    ++chunk.count;
    for (std::size_t axis = 0; axis < 3; ++axis)
        mLargestSlope[axis] = std::max(mLargestSlope[axis], std::abs(particle.slope[axis]));
}

void ParticleBins::take(std::size_t tile, std::vector<Particle>& particles, std::vector<std::uint32_t>& generations,
                        ParticleBins& user)
{
    for (auto& chunk : mBins[tile]) {
        const std::uint32_t* words = chunk->generations.get();
        particles.insert(particles.end(), chunk->particles.begin(),
                         chunk->particles.begin() + std::ptrdiff_t(chunk->count));
        generations.insert(generations.end(), words, words + chunk->count * mGenerations);
        chunk->count = 0;
        user.mSpare.push_back(std::move(chunk));
    }
    Bin().swap(mBins[tile]);
}

} // namespace vdblic
