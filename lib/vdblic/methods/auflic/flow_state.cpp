#include "vdblic/methods/auflic/flow_state.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/for_leaves.h"
#include "vdblic/field/vector.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/hits.h"
#include "vdblic/noise/noise.h"

#include <fmt/format.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;
using openvdb::points::AttributeHandle;
using openvdb::points::AttributeWriteHandle;
using openvdb::points::PointDataGrid;
using PointLeaf = openvdb::points::PointDataTree::LeafNodeType;

constexpr const char *kNoise = "noise", *kMean = "mean", *kWeight = "weight", *kParticles = "particles";
constexpr const char *kPosition = "P", *kSlope = "slope", *kId = "id", *kAlive = "alive", *kWords = "words";
constexpr float kScale = 65536; // exact in a float; its low bytes are zero, which compresses well

/// The voxel with the nearest centre. In double precision, so that the distance to it is exact in a float: single
/// precision rounds 0.49999997 to voxel 1, whose distance needs one bit too many. Both voxels lie in one leaf.
Coord nearestVoxel(const std::array<float, 3>& position)
{
    Coord voxel;
    for (int axis = 0; axis < 3; ++axis)
        voxel[axis] = int(std::floor(double(position[std::size_t(axis)]) + 0.5));
    return voxel;
}

/// The points of one leaf, voxel by voxel.
class LeafPoints {
  public:
    LeafPoints(const std::vector<ParticleBins>& bins, std::size_t tile)
    {
        for (const ParticleBins& some : bins) {
            some.forEach(tile, [&](const Particle& particle, const std::uint32_t* words) {
                mPoints.push_back({particle, words, nearestVoxel(particle.position)});
            });
        }
        // Sorted by id within a voxel: equal states give equal files, whatever thread held a particle.
        std::sort(mPoints.begin(), mPoints.end(), [](const Point& a, const Point& b) {
            const auto key = [](const Point& p) { return std::pair(PointLeaf::coordToOffset(p.voxel), p.particle.id); };
            return key(a) < key(b);
        });
    }

    /// @param words per particle beside its Hits
    void write(PointLeaf& leaf, openvdb::Index words) const
    {
        leaf.setOffsets(ends());
        AttributeWriteHandle<Vec3f> position(leaf.attributeArray(kPosition)), slope(leaf.attributeArray(kSlope));
        AttributeWriteHandle<std::int64_t> id(leaf.attributeArray(kId)), alive(leaf.attributeArray(kAlive));
        openvdb::Index n = 0;
        for (const Point& point : mPoints) {
            const Particle& particle = point.particle;
            const openvdb::Vec3d from(particle.position[0], particle.position[1], particle.position[2]);
            position.set(n, Vec3f(from - point.voxel.asVec3d()));
            slope.set(n, Vec3f(particle.slope.data()));
            id.set(n, std::int64_t(particle.id));
            alive.set(n, std::int64_t(particle.alive));
            ++n;
        }
        if (words > 0) writeWords(leaf, words);
    }

  private:
    void writeWords(PointLeaf& leaf, openvdb::Index words) const
    {
        AttributeWriteHandle<std::int32_t> all(leaf.attributeArray(kWords));
        openvdb::Index n = 0;
        for (const Point& point : mPoints) {
            for (openvdb::Index i = 0; i < words; ++i)
                all.set(n, i, std::int32_t(point.words[i]));
            ++n;
        }
    }

    /// For each voxel: the number of points up to and including it.
    [[nodiscard]] std::vector<PointLeaf::ValueType> ends() const
    {
        std::vector<PointLeaf::ValueType> ends;
        ends.reserve(PointLeaf::SIZE);
        auto point = mPoints.begin();
        for (openvdb::Index voxel = 0; voxel < PointLeaf::SIZE; ++voxel) {
            while (point != mPoints.end() && PointLeaf::coordToOffset(point->voxel) == voxel)
                ++point;
            ends.emplace_back(std::uint32_t(point - mPoints.begin()));
        }
        return ends;
    }

    struct Point {
        Particle particle;
        const std::uint32_t* words;
        Coord voxel;
    };
    std::vector<Point> mPoints;
};

template<typename T>
AttributeHandle<T> attributeOf(const PointLeaf& leaf, const char* name, openvdb::Index count, openvdb::Index stride = 1)
{
    const openvdb::points::AttributeArray* array = leaf.attributeSet().getConst(name);
    if (!array || !array->hasValueType<T>() || array->size() != count || !array->hasConstantStride() ||
        array->stride() != stride) {
        throw InputError(fmt::format("its particles have no attribute '{}' as this run's would", name));
    }
    return AttributeHandle<T>(*array);
}

/// The number of a leaf's points. @throws InputError if the voxels' counts descend
openvdb::Index countPoints(const PointLeaf& leaf)
{
    openvdb::Index count = 0;
    for (openvdb::Index voxel = 0; voxel < PointLeaf::SIZE; ++voxel) {
        const openvdb::Index end = leaf.getValue(voxel);
        if (end < count) throw InputError("its particles are not in the order of their voxels");
        count = end;
    }
    return count;
}

/// Add a leaf's points to the bin of a tile.
void readLeaf(const PointLeaf& leaf, std::size_t tile, ParticleBins& bins)
{
    const openvdb::Index count = countPoints(leaf);
    const auto position = attributeOf<Vec3f>(leaf, kPosition, count), slope = attributeOf<Vec3f>(leaf, kSlope, count);
    const auto id = attributeOf<std::int64_t>(leaf, kId, count), alive = attributeOf<std::int64_t>(leaf, kAlive, count);
    std::vector<std::uint32_t> words(bins.words());
    std::optional<AttributeHandle<std::int32_t>> allWords;
    if (!words.empty()) allWords.emplace(attributeOf<std::int32_t>(leaf, kWords, count, openvdb::Index(words.size())));
    openvdb::Index n = 0;
    for (openvdb::Index voxel = 0; voxel < PointLeaf::SIZE; ++voxel) {
        const openvdb::Vec3d centre = leaf.offsetToGlobalCoord(voxel).asVec3d();
        for (const openvdb::Index end = leaf.getValue(voxel); n < end; ++n) {
            Particle particle{};
            const Vec3f distance = position.get(n), velocity = slope.get(n);
            for (int axis = 0; axis < 3; ++axis) {
                const auto at = std::size_t(axis);
                particle.position[at] = float(centre[axis] + double(distance[axis]));
                particle.slope[at] = velocity[axis];
                if (!(std::abs(distance[axis]) <= 0.5f) || !std::isfinite(velocity[axis])) {
                    throw InputError("a particle is outside its voxel, or its slope is no number");
                }
            }
            particle.id = std::uint64_t(id.get(n));
            particle.alive = std::uint64_t(alive.get(n));
            const std::uint64_t hits = Hits::count(particle.alive);
            if (hits == 0 || hits > Particle::kMostHits || Hits::sum(particle.alive) > hits * kNoiseMax)
                throw InputError("a particle carries values that no run leaves");
            for (openvdb::Index i = 0; i < openvdb::Index(words.size()); ++i)
                words[i] = std::uint32_t(allWords->get(n, i));
            bins.add(tile, particle, words.data());
        }
    }
}

/// Add a file's particles to the bins of their tiles, the domain's own leaves.
void readParticles(const Domain& domain, const VdbFile& file, ParticleBins& bins)
{
    const auto grid = file.find<PointDataGrid>(kParticles);
    if (!grid) throw InputError(fmt::format("it has no points '{}'", kParticles));
    for (auto leaf = grid->constTree().cbeginLeaf(); leaf; ++leaf) {
        const Coord origin = leaf->origin();
        const int tile = domain.findLeaf(Int4{origin[0], origin[1], origin[2], 0});
        if (tile >= 0 && domain.isOwn(std::size_t(tile))) {
            readLeaf(*leaf, std::size_t(tile), bins);
        } else if (domain.isWhole()) {
            throw InputError("it has particles outside the frame it is for");
        }
    }
}

std::vector<std::string> namesOf(bool hasMean)
{
    return hasMean ? std::vector<std::string>{kNoise, kMean, kWeight} : std::vector<std::string>{kNoise};
}

} // namespace

FlowStateReader::FlowStateReader(const Domain& domain, std::size_t words, bool hasMean)
    : mDomain(domain), mGrids(domain, namesOf(hasMean)), mState{LeafValues<std::int32_t>(domain, 0, domain.own()),
                                                                std::nullopt, ParticleBins(domain.leafCount(), words)}
{
    if (hasMean)
        mState.mean = {LeafValues<float>(domain, 0.0f, domain.own()), LeafValues<float>(domain, 0.0f, domain.own())};
}

void FlowStateReader::add(const VdbFile& file)
{
    const auto read = [&](const char* name, const auto& readVoxel) {
        mGrids.read(file, name, [&](std::size_t leaf, const float* values) {
            for (auto voxel = mDomain.mask(leaf).beginOn(); voxel; ++voxel)
                readVoxel(leaf, voxel.pos(), values[voxel.pos()]);
        });
    };
    read(kNoise, [&](std::size_t leaf, openvdb::Index at, float noise) {
        mState.input[leaf][at] = std::int32_t(std::clamp(noise * kScale, 0.0f, float(kNoiseMax)));
    });
    if (mState.mean) {
        auto& [mean, weight] = *mState.mean;
        read(kMean, [&, &to = mean](std::size_t leaf, openvdb::Index at, float value) { to[leaf][at] = value; });
        read(kWeight, [&, &to = weight](std::size_t leaf, openvdb::Index at, float value) { to[leaf][at] = value; });
    }
    readParticles(mDomain, file, mState.particles);
}

FlowState FlowStateReader::finish()
{
    mGrids.finish();
    return std::move(mState);
}

openvdb::GridBase::Ptr inputGrid(const Domain& domain, Domain::Leaves leaves, const LeafValues<std::int32_t>& input)
{
    LeafValues<float> noise(domain, 0.0f, leaves);
    forLeaves(leaves, [&](std::size_t leaf) {
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel)
            noise[leaf][voxel.pos()] = float(input[leaf][voxel.pos()]) / kScale;
    });
    auto grid = openvdb::FloatGrid::create(noise.tree());
    grid->setName(kNoise);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

openvdb::GridPtrVec meanGrids(const Domain& domain, Domain::Leaves leaves, const RunningMean& mean)
{
    return {stateGrid(domain, leaves, mean.mean, kMean), stateGrid(domain, leaves, mean.weight, kWeight)};
}

openvdb::GridBase::Ptr particleGrid(const Domain& domain, Domain::Leaves some, const std::vector<ParticleBins>& bins)
{
    openvdb::initialize(); // registers the attribute types
    const auto words = openvdb::Index(bins.empty() ? 0 : bins.front().words());
    auto grid = PointDataGrid::create();
    grid->setName(kParticles);
    const auto descriptor =
        openvdb::points::AttributeSet::Descriptor::create(openvdb::points::TypedAttributeArray<Vec3f>::attributeType());
    std::vector<PointLeaf*> leaves(domain.leafCount(), nullptr);
    for (const std::uint32_t leaf : some) {
        openvdb::Index count = 0;
        for (const ParticleBins& particles : bins)
            particles.forEach(leaf, [&](auto&&...) { ++count; });
        if (count == 0) continue;
        leaves[leaf] = grid->tree().touchLeaf(domain.origin(leaf));
        leaves[leaf]->initializeAttributes(descriptor, count);
    }
    openvdb::points::appendAttribute<Vec3f>(grid->tree(), kSlope);
    openvdb::points::appendAttribute<std::int64_t>(grid->tree(), kId);
    openvdb::points::appendAttribute<std::int64_t>(grid->tree(), kAlive);
    if (words > 0) openvdb::points::appendAttribute<std::int32_t>(grid->tree(), kWords, 0, words);
    forLeaves(some, [&](std::size_t leaf) {
        if (leaves[leaf]) LeafPoints(bins, leaf).write(*leaves[leaf], words);
    });
    return grid;
}

} // namespace vdblic
