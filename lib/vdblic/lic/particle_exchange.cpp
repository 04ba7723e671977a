#include "vdblic/lic/particle_exchange.h"

#include "vdblic/distributed/message.h"

#include <cstddef>
#include <cstdint>
#include <utility>

namespace vdblic {

void handOn(Exchange& exchange, const Partition& partition, const Domain& domain, std::vector<ParticleBins>& bins)
{
    std::vector<Exchange::Bytes> messages(std::size_t(exchange.size()));
    std::vector<Particle> particles;
    std::vector<std::uint32_t> generations;
    for (const std::uint32_t leaf : domain.local()) {
        if (domain.isOwn(leaf)) continue;
        particles.clear();
        generations.clear();
        for (ParticleBins& some : bins)
            some.take(leaf, particles, generations, some);
        if (particles.empty()) continue;
        Exchange::Bytes& message = messages[std::size_t(partition.ownerOfTexture(domain.origin(leaf)))];
        put(message, leaf);
        put(message, std::uint32_t(particles.size()));
        put(message, particles.data(), particles.size());
        put(message, generations.data(), generations.size());
    }
    for (ParticleBins& some : bins)
        some.freeSpare();
    const std::size_t words = bins.front().generations();
    ParticleBins arrived(domain.leafCount(), words);
    for (const Exchange::Bytes& bytes : exchange.swap(std::move(messages))) {
        for (MessageReader message(bytes); !message.atEnd();) {
            const auto leaf = message.get<std::uint32_t>();
            particles.resize(message.get<std::uint32_t>());
            generations.resize(particles.size() * words);
            message.get(particles.data(), particles.size());
            message.get(generations.data(), generations.size());
            for (std::size_t i = 0; i < particles.size(); ++i)
                arrived.add(leaf, particles[i], generations.data() + i * words);
        }
    }
    bins.push_back(std::move(arrived));
}

} // namespace vdblic
