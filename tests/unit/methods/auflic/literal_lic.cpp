#include "methods/auflic/literal_lic.h"

#include "methods/auflic/literal_filter.h"
#include "methods/auflic/literal_path.h"
#include "vdblic/noise/noise_field.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace vdblic::test {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

struct Bucket {
    std::map<Coord, std::pair<std::uint64_t, std::uint64_t>> hits; // sum, count
};

/// A pathline, step by step from the SCAP that started it.
struct Path {
    std::uint64_t releaseStep, releaseRank;
    std::size_t firstStep;
    std::vector<Coord> starts;                       // voxel in which step firstStep + i began
    std::vector<std::vector<LiteralSample>> samples; // voxels that it passed
    bool ended = false;                              // left the domain in the last step
    Vec3f position, slope;

    [[nodiscard]] std::size_t nextStep() const { return firstStep + samples.size(); }
};

Coord tileOf(const Coord& voxel)
{
    return voxel & ~7;
}
Vec3f centreOf(const Coord& voxel)
{
    return Vec3f(voxel.asVec3s());
}
Vec3f velocityAt(const LiteralField& field, const Coord& voxel)
{
    return field.at(centreOf(voxel), 0).value_or(Vec3f(0));
}

class LiteralLic {
  public:
    LiteralLic(const std::vector<VelocityFrame>& frames, int steps, const TextureParams& params)
        : mParams(params), mBuckets(std::size_t(params.lifeSpan)), mNoise(7),
          mInput(noiseInput(*frames[0].domain.texture, mNoise))
    {
        for (std::size_t k = 0; k < std::size_t(steps); ++k)
            mFields.emplace_back(frames[k], frames[k + 1]);
    }

    LeafValues<float> scatteringProcess(std::size_t k, const Domain& next)
    {
        if (mParams.method == &kUflic) {
            forEachVoxel(k, [&](const Coord& voxel, std::uint64_t rank) {
                Path path = start(k, voxel, rank);
                extend(path, k + std::size_t(mParams.lifeSpan));
                scatterSeed(k, path, 0, inputAt(voxel));
            });
        } else {
            seedAlongPathlines(k);
        }

        // Convolve the bucket of step k, which no later SCAP adds to.
        Bucket& bucket = mBuckets[k % mBuckets.size()];
        LeafValues<float> texture(*mFields[k].start().domain.texture, 0.0f);
        for (auto leaf = texture.tree()->beginLeaf(); leaf; ++leaf) {
            for (auto value = leaf->beginValueOn(); value; ++value) {
                const auto hits = bucket.hits.find(value.getCoord());
                const float mean = hits == bucket.hits.end()
                                       ? float(inputAt(value.getCoord()))
                                       : float(double(hits->second.first) / double(hits->second.second));
                value.setValue(mean / 65535.0f);
            }
        }
        bucket = {};
        mInput = literalFeedForward(mFields[k], texture, next, mNoise, {}, k);
        return texture;
    }

  private:
    template<typename Visit>
    void forEachVoxel(std::size_t k, const Visit& visit)
    {
        std::uint64_t rank = 0;
        for (auto leaf = topology(k).cbeginLeaf(); leaf; ++leaf) {
            for (auto voxel = leaf->cbeginValueOn(); voxel; ++voxel)
                visit(voxel.getCoord(), rank++);
        }
    }

    const openvdb::MaskTree& topology(std::size_t step) const
    {
        return mFields[step].start().domain.texture->topology();
    }
    std::uint32_t inputAt(const Coord& voxel) const { return std::uint32_t(mInput.tree()->getValue(voxel)); }

    bool inDomain(std::size_t step, const Coord& voxel) const { return topology(step).isValueOn(voxel); }

    Path start(std::size_t k, const Coord& voxel, std::uint64_t rank) const
    {
        return {k, rank, k, {}, {}, false, centreOf(voxel), velocityAt(mFields[k], voxel)};
    }

    /// Integrate a path up to, not including, step `end`; steps after the last texture are left out.
    void extend(Path& path, std::size_t end) const
    {
        while (!path.ended && path.nextStep() < std::min(end, mFields.size())) {
            const std::size_t step = path.nextStep();
            path.starts.push_back(voxelAround(path.position));
            path.samples.emplace_back();
            if (!inDomain(step, voxelAround(path.position))) {
                path.ended = true;
                return;
            }
            LiteralTrace oneStep = literalTrace(mFields[step], mParams, path.position, path.slope);
            path.samples.back() = std::move(oneStep.samples);
            path.ended = oneStep.ended;
            path.position = oneStep.position;
            path.slope = oneStep.slope;
        }
    }

    /// Add a seed's value along the rest of its path: from a sample of step k to the end of its life span.
    void scatterSeed(std::size_t k, const Path& path, std::size_t fromSample, std::uint32_t value)
    {
        const std::size_t end = std::min(k + std::size_t(mParams.lifeSpan), path.nextStep());
        for (std::size_t step = k; step < end; ++step) {
            const auto& samples = path.samples[step - path.firstStep];
            for (std::size_t i = step == k ? fromSample : 0; i < samples.size(); ++i) {
                auto& [sum, count] = mBuckets[step % mBuckets.size()].hits[samples[i].voxel];
                sum += value;
                ++count;
            }
        }
    }

    /// Release a seed in every open voxel the path passes within the release window; false if there was none.
    bool releaseAlong(std::size_t k, const Path& path, const Coord& tile, std::set<Coord>& open)
    {
        const Coord& start = path.starts[k - path.firstStep];
        bool released = inDomain(k, start) && tileOf(start) == tile && open.erase(start) > 0;
        if (released) scatterSeed(k, path, 0, inputAt(start));
        const auto& samples = path.samples[k - path.firstStep];
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const Coord& voxel = samples[i].voxel;
            if (!samples[i].early || tileOf(voxel) != tile || open.erase(voxel) == 0) continue;
            released = true;
            scatterSeed(k, path, i, inputAt(voxel));
        }
        return released;
    }

    void seedAlongPathlines(std::size_t k)
    {
        const std::size_t end = k + std::size_t(mParams.lifeSpan);
        std::map<Coord, std::set<Coord>> open;
        std::vector<std::pair<Coord, std::uint64_t>> scan;
        forEachVoxel(k, [&](const Coord& voxel, std::uint64_t rank) {
            open[tileOf(voxel)].insert(voxel);
            scan.emplace_back(voxel, rank);
        });
        std::vector<Path> saved;
        // Pathline reuse, the oldest first; a blocked pathline is deleted.
        for (Path& path : mSaved) {
            if (path.ended && path.nextStep() <= k) continue;
            extend(path, k + 1);
            const Coord tile = tileOf(path.starts[k - path.firstStep]);
            if (!inDomain(k, path.starts[k - path.firstStep])) continue;
            extend(path, end);
            if (releaseAlong(k, path, tile, open[tile])) saved.push_back(path);
        }
        // The image is scanned for voxels still open.
        for (const auto& [voxel, rank] : scan) {
            if (!open[tileOf(voxel)].contains(voxel)) continue;
            Path path = start(k, voxel, rank);
            extend(path, end);
            if (releaseAlong(k, path, tileOf(voxel), open[tileOf(voxel)])) saved.push_back(path);
        }
        // Reuse takes the latter part of a pathline; one step long it has none.
        if (mParams.lifeSpan == 1) saved.clear();
        std::sort(saved.begin(), saved.end(), [](const Path& a, const Path& b) {
            return std::pair(a.releaseStep, a.releaseRank) < std::pair(b.releaseStep, b.releaseRank);
        });
        mSaved = std::move(saved);
    }

    TextureParams mParams;
    std::vector<LiteralField> mFields;
    std::vector<Bucket> mBuckets;
    NoiseField mNoise;
    LeafValues<std::int32_t> mInput;
    std::vector<Path> mSaved;
};

/// With history: particle by particle and deposit by deposit, all in maps.
class LiteralHistory {
  public:
    LiteralHistory(const TextureParams& params, const Domain& first)
        : mParams(params), mNoise(7), mInput(noiseInput(first, mNoise))
    {
    }

    LeafValues<float> step(std::size_t k, const LiteralField& field, const Domain& next)
    {
        const openvdb::MaskTree& domain = field.start().domain.texture->topology();
        mHits.clear();
        mOpen.clear();
        std::vector<Mote> scan;
        for (auto leaf = domain.cbeginLeaf(); leaf; ++leaf) {
            for (auto voxel = leaf->cbeginValueOn(); voxel; ++voxel) {
                const Coord at = voxel.getCoord();
                mOpen.insert(at);
                scan.push_back({k, scan.size(), centreOf(at), velocityAt(field, at)});
            }
        }

        // Particles in one voxel become one; those released last go first.
        std::map<Coord, Mote> byVoxel;
        std::sort(mMotes.begin(), mMotes.end(), goesFirst);
        for (const Mote& mote : mMotes) {
            if (!domain.isValueOn(voxelAround(mote.position))) continue;
            const auto [heir, isFirst] = byVoxel.try_emplace(voxelAround(mote.position), mote);
            if (isFirst) continue;
            heir->second.sum += mote.sum;
            heir->second.weight += mote.weight;
        }
        std::vector<Mote> live;
        live.reserve(byVoxel.size());
        for (const auto& [voxel, mote] : byVoxel)
            live.push_back(mote);
        std::sort(live.begin(), live.end(), goesFirst);

        mMotes.clear();
        for (Mote& mote : live)
            scatter(field, mote);
        for (Mote& mote : scan) {
            const Coord voxel = voxelAround(mote.position);
            const auto before = std::uint32_t(mInput.tree()->getValue(voxel));
            if (mParams.lifeSpan > 1) mote.weight = kWeight * (3 * std::uint64_t(mParams.lifeSpan) - 4) / 4;
            mote.sum = mote.weight * before;
            scatter(field, mote);
        }

        LeafValues<float> texture(*field.start().domain.texture, 0.0f);
        for (auto value = texture.tree()->beginValueOn(); value; ++value) {
            const auto hits = mHits.find(value.getCoord());
            value.setValue((hits == mHits.end() ? float(mInput.tree()->getValue(value.getCoord()))
                                                : float(double(hits->second.first) / double(hits->second.second))) /
                           65535.0f);
        }
        texture = literalMeanAlongFlow(field.start(), texture);
        mInput = literalFeedForward(field, texture, next, mNoise, {.deviation = 1.08f * FeedbackParams{}.deviation}, k);
        return texture;
    }

  private:
    static constexpr std::uint64_t kWeight = 32; // of a value that is taken up

    struct Mote {
        std::size_t releaseStep, rank;
        Vec3f position, slope;
        std::uint64_t sum = 0, weight = 0; // of the values it carries
    };
    static bool goesFirst(const Mote& a, const Mote& b)
    {
        return a.releaseStep != b.releaseStep ? a.releaseStep > b.releaseStep : a.rank < b.rank;
    }

    void scatter(const LiteralField& field, Mote mote)
    {
        const Coord start = voxelAround(mote.position);
        if (!mOpen.contains(start)) return;
        const auto takeUp = [&](const Coord& voxel) {
            if (tileOf(voxel) != tileOf(start) || mOpen.erase(voxel) == 0) return;
            mote.sum += kWeight * std::uint64_t(mInput.tree()->getValue(voxel));
            mote.weight += kWeight;
        };
        takeUp(start);
        const LiteralTrace path = literalTrace(field, mParams, mote.position, mote.slope);
        for (const LiteralSample& sample : path.samples) {
            if (sample.early) takeUp(sample.voxel);
            mHits[sample.voxel].first += mote.sum;
            mHits[sample.voxel].second += mote.weight;
        }
        const double share = 4 / (3.0 * mParams.lifeSpan);
        const auto lost = std::min(std::uint64_t(std::floor(double(mote.weight) * share + 0.5)), mote.weight);
        mote.sum -= mote.sum * lost / mote.weight;
        mote.weight -= lost;
        if (path.ended || mote.weight == 0) return;
        mote.position = path.position;
        mote.slope = path.slope;
        mMotes.push_back(mote);
    }

    TextureParams mParams;
    NoiseField mNoise;
    LeafValues<std::int32_t> mInput;
    std::vector<Mote> mMotes;
    std::set<Coord> mOpen;
    std::map<Coord, std::pair<std::uint64_t, std::uint64_t>> mHits;
};

} // namespace

std::vector<LeafValues<float>> literalTexturesWithHistory(const std::vector<VelocityFrame>& frames, int steps,
                                                          const TextureParams& scatter)
{
    LiteralHistory literal(scatter, *frames[0].domain.texture);
    std::vector<LeafValues<float>> textures;
    for (std::size_t k = 0; k < std::size_t(steps); ++k) {
        textures.push_back(literal.step(k, {frames[k], frames[k + 1]}, *frames[k + 1].domain.texture));
    }
    return textures;
}

std::vector<LeafValues<float>> literalTextures(const std::vector<VelocityFrame>& frames, int steps,
                                               const TextureParams& scatter)
{
    LiteralLic literal(frames, steps, scatter);
    std::vector<LeafValues<float>> textures;
    textures.reserve(std::size_t(steps));
    for (int k = 0; k < steps; ++k)
        textures.push_back(literal.scatteringProcess(std::size_t(k), *frames[std::size_t(k) + 1].domain.texture));
    return textures;
}

} // namespace vdblic::test
