#include "lic/literal_lic.h"

#include <map>
#include <set>

namespace vdblic::test {
namespace {

using openvdb::Coord;

struct Bucket {
    std::map<Coord, std::pair<std::uint64_t, std::uint64_t>> hits; // sum, count
};

/// A voxel that a pathline is in, and when.
struct Sample {
    Coord voxel;
    float time;
};

/// A pathline, step by step from the SCAP that started it.
struct Path {
    std::uint64_t releaseStep, releaseRank;
    std::size_t firstStep;
    std::vector<Coord> starts;                // where step firstStep + i began
    std::vector<std::vector<Sample>> samples; // and what it passed
    bool ended = false;                       // left the domain in the last of them
    Float4 position, slope;

    [[nodiscard]] std::size_t nextStep() const { return firstStep + samples.size(); }
};

class LiteralLic {
  public:
    LiteralLic(const std::vector<FlowFrame>& frames, int steps, const ScatterParams& params)
        : mParams(params), mFields(std::size_t(steps)), mBuckets(std::size_t(params.lifeSpan)), mNoise(7)
    {
        for (std::size_t k = 0; k < mFields.size(); ++k) {
            mFields[k].build(frames[k].domain, {frames[k].velocities->tree(), openvdb::Mat3d::identity()},
                             {frames[k + 1].velocities->tree(), openvdb::Mat3d::identity()});
        }
        mInput = noiseInput(mFields[0].domain(), mNoise);
    }

    LeafValues<float> scatteringProcess(std::size_t k, const Domain& next)
    {
        if (mParams.method == ScatterMethod::kUflic) {
            forEachVoxel(k, [&](const Coord& voxel, std::uint64_t rank) {
                Path path = start(k, voxel, rank);
                extend(path, k + std::size_t(mParams.lifeSpan));
                scatterSeed(k, path, 0, inputAt(k, voxel));
            });
        } else {
            seedAlongPathlines(k);
        }

        // Convolve the bucket of step k, which no later SCAP adds to.
        Bucket& bucket = mBuckets[k % mBuckets.size()];
        const Domain& domain = mFields[k].domain();
        LeafValues<float> texture(domain, 0.0f);
        for (auto leaf = texture.tree()->beginLeaf(); leaf; ++leaf) {
            for (auto value = leaf->beginValueOn(); value; ++value) {
                const auto hits = bucket.hits.find(value.getCoord());
                const float mean = hits == bucket.hits.end()
                                       ? float(inputAt(k, value.getCoord()))
                                       : float(double(hits->second.first) / double(hits->second.second));
                value.setValue(mean / 65535.0f);
            }
        }
        bucket = {};
        mInput = feedForward(mFields[k], texture, next, mNoise, FeedbackParams{}, k);
        return texture;
    }

  private:
    template<typename Visit>
    void forEachVoxel(std::size_t k, const Visit& visit)
    {
        const Domain& domain = mFields[k].domain();
        std::uint64_t rank = 0;
        for (auto leaf = domain.topology().cbeginLeaf(); leaf; ++leaf) {
            for (auto voxel = leaf->cbeginValueOn(); voxel; ++voxel)
                visit(voxel.getCoord(), rank++);
        }
    }

    std::uint32_t inputAt(std::size_t, const Coord& voxel) const
    {
        return std::uint32_t(mInput.tree()->getValue(voxel));
    }

    static Coord voxelAt(Float4 position)
    {
        const Int4 voxel = voxelOf(position);
        return {voxel[0], voxel[1], voxel[2]};
    }
    static Coord tileOf(const Coord& voxel) { return voxel & ~7; }
    bool inDomain(std::size_t step, const Coord& voxel) const
    {
        return mFields[step].domain().topology().isValueOn(voxel);
    }

    Path start(std::size_t k, const Coord& voxel, std::uint64_t rank) const
    {
        const Float4 centre = {float(voxel[0]), float(voxel[1]), float(voxel[2]), 0};
        return {k, rank, k, {}, {}, false, centre, mFields[k].sample(centre, 0, Float4{})};
    }

    /// Integrate a path up to, not including, a step; steps that are never shown are left out.
    void extend(Path& path, std::size_t end) const
    {
        while (!path.ended && path.nextStep() < std::min(end, mFields.size())) {
            const std::size_t step = path.nextStep();
            path.starts.push_back(voxelAt(path.position));
            path.samples.emplace_back();
            if (!inDomain(step, voxelAt(path.position))) {
                path.ended = true;
                return;
            }
            PathBatch batch;
            batch.count = 1;
            batch.position[0] = path.position;
            batch.slope[0] = path.slope;
            advancePaths(mFields[step], mParams.pathline, batch);
            for (const Segment& segment : batch.path[0]) {
                if (path.ended) break;
                visitSamples(segment, mParams.pathline.sampleSpacing, [&](const SampleBlock& block) {
                    for (int i = 0; i < block.count && !path.ended; ++i) {
                        const Coord voxel(block.x[i], block.y[i], block.z[i]);
                        path.ended = !inDomain(step, voxel);
                        if (!path.ended) path.samples.back().push_back({voxel, block.time[i]});
                    }
                    return true;
                });
            }
            path.position = batch.position[0];
            path.slope = batch.slope[0];
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
        if (released) scatterSeed(k, path, 0, inputAt(k, start));
        const auto& samples = path.samples[k - path.firstStep];
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const Coord& voxel = samples[i].voxel;
            if (samples[i].time >= mParams.releaseWindow || tileOf(voxel) != tile || open.erase(voxel) == 0) continue;
            released = true;
            scatterSeed(k, path, i, inputAt(k, voxel));
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

    ScatterParams mParams;
    std::vector<VelocityField> mFields;
    std::vector<Bucket> mBuckets;
    NoiseField mNoise;
    LeafValues<std::int32_t> mInput;
    std::vector<Path> mSaved;
};

} // namespace

std::vector<LeafValues<float>> literalTextures(const std::vector<FlowFrame>& frames, int steps,
                                               const ScatterParams& scatter)
{
    LiteralLic literal(frames, steps, scatter);
    std::vector<LeafValues<float>> textures;
    for (int k = 0; k < steps; ++k) {
        textures.push_back(literal.scatteringProcess(std::size_t(k), *frames[std::size_t(k) + 1].domain));
    }
    return textures;
}

} // namespace vdblic::test
