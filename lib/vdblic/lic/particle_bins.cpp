#include "vdblic/lic/particle_bins.h"

#include <utility>

namespace vdblic {

ParticleBins::Chunk& ParticleBins::grow(Bin& bin)
{
    if (mSpare.empty()) {
        bin.emplace_back(new Chunk); // not make_unique: it would zero the particles
        if (mGenerations > 0) bin.back()->generations.reset(new std::uint32_t[Chunk::kCapacity * mGenerations]);
    } else {
        bin.push_back(std::move(mSpare.back()));
        mSpare.pop_back();
    }
    return *bin.back();
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
