#include "vdblic/methods/auflic/particle_bins.h"

#include <utility>

namespace vdblic {

void ParticleBins::grow(Bin& bin)
{
    if (mSpare.empty()) {
        bin.chunks.emplace_front();
    } else {
        bin.chunks.splice_after(bin.chunks.before_begin(), mSpare, mSpare.before_begin());
    }
}

void ParticleBins::take(std::size_t tile, std::vector<Particle>& particles, std::vector<std::uint32_t>& words,
                        ParticleBins& user)
{
    Bin bin = std::move(mBins[tile]);
    mBins[tile] = Bin();
    forEachChunk(bin, [&](std::span<const Particle> some, const std::uint32_t* ofSome) {
        particles.insert(particles.end(), some.begin(), some.end());
        words.insert(words.end(), ofSome, ofSome + some.size() * mWords);
    });
    user.mSpare.splice_after(user.mSpare.before_begin(), std::move(bin.chunks));
}

} // namespace vdblic
