#include "vdblic/methods/auflic/flow_state.h"

#include "vdblic/methods/auflic/fading_values.h"

#include "methods/test_flow.h"
#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/hits.h"
#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/registry.h"
#include "vdblic/noise/noise.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <openvdb/tools/Count.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3f;

constexpr int kStateSteps = 9;

/// Grids written to a file and read again.
VdbFile throughAFile(const openvdb::GridPtrVec& grids)
{
    const TemporaryFolder folder;
    writeVdb(folder / "state.vdb", openvdb::GridCPtrVec(grids.begin(), grids.end()), {});
    return readVdb(folder / "state.vdb");
}

std::vector<VdbFile> throughFiles(FlowTexture& texture)
{
    const TextureMemory& memory = test::memoryOf(texture);
    std::vector<VdbFile> files;
    for (std::size_t part = 0; part < memory.parts(); ++part)
        files.push_back(throughAFile(memory.save(part).grids));
    return files;
}

/// Returns the files one by one.
auto source(std::vector<VdbFile> files)
{
    return [files = std::move(files), next = std::size_t(0)]() mutable {
        return next < files.size() ? std::optional(files[next++]) : std::nullopt;
    };
}

/// What a state's particles are after a file.
ParticleBins readAgain(const Domain& domain, const std::vector<ParticleBins>& bins, std::size_t generations)
{
    const LeafValues<std::int32_t> input(domain, 0);
    FlowStateReader reader(domain, generations, false);
    reader.add(throughAFile({inputGrid(domain, domain.own(), input), particleGrid(domain, domain.own(), bins)}));
    return reader.finish().particles;
}

std::size_t differingVoxels(const LeafValues<float>& a, const LeafValues<float>& b)
{
    EXPECT_TRUE(a.tree()->hasSameTopology(*b.tree()));
    std::size_t differing = 0;
    for (auto value = a.tree()->cbeginValueOn(); value; ++value)
        differing +=
            std::bit_cast<std::uint32_t>(*value) != std::bit_cast<std::uint32_t>(b.tree()->getValue(value.getCoord()));
    return differing;
}

class SavedState : public testing::TestWithParam<TextureParams> {};

TEST_P(SavedState, GoesOnToTheBitFromAnyStep)
{
    const auto frames = test::unsteadyFlowWithHole(kStateSteps + 1); // every frame has another domain
    const auto expected = test::streamedTextures(frames, kStateSteps, GetParam());
    for (const std::size_t saved : {1, 2, 5, 8}) {
        const auto before = makeFlowTexture({GetParam()}, {NoiseField(7)});
        for (std::size_t k = 0; k < saved; ++k)
            (void)before->advance(test::stepFrom(frames, k));
        const auto after = makeFlowTexture({GetParam()}, {NoiseField(7)});
        test::memoryOf(*after).restore(saved, 1, frames[saved].domain.texture, source(throughFiles(*before)));
        for (std::size_t k = saved; k < kStateSteps; ++k) {
            EXPECT_EQ(differingVoxels(after->advance(test::stepFrom(frames, k)).texture, expected[k]), 0u)
                << "step " << k << " after " << saved;
        }
        // Saving takes nothing away.
        for (std::size_t k = saved; k < kStateSteps; ++k) {
            EXPECT_EQ(differingVoxels(before->advance(test::stepFrom(frames, k)).texture, expected[k]), 0u);
        }
    }
}

TextureParams savedParams(const TextureMethod* method, int lifeSpan)
{
    TextureParams result;
    result.method = method;
    result.lifeSpan = lifeSpan;
    return result;
}

std::string savedName(const testing::TestParamInfo<TextureParams>& info)
{
    const char* method = info.param.method == &kUflic    ? "Uflic"
                         : info.param.method == &kAuflic ? "Auflic"
                                                         : "Auflic2004";
    return fmt::format("{}Life{}", method, info.param.lifeSpan);
}

INSTANTIATE_TEST_SUITE_P(Methods, SavedState,
                         testing::Values(savedParams(&kUflic, 4), savedParams(&kAuflic2004, 4),
                                         savedParams(&kAuflic, 4), savedParams(&kAuflic, 1), savedParams(&kAuflic, 20)),
                         savedName);

std::shared_ptr<const Domain> box(const openvdb::CoordBBox& voxels)
{
    auto topology = std::make_shared<openvdb::MaskTree>();
    topology->fill(voxels, true);
    return std::make_shared<Domain>(std::move(topology));
}

TEST(ParticleGrid, KeepsEveryBitOfAParticle)
{
    const auto domain = box({{-16, -16, -16}, {15, 15, 15}});
    ParticleBins bins(domain->leafCount(), 2);
    std::map<std::uint64_t, std::pair<Particle, std::array<std::uint32_t, 2>>> expected;
    const float half = 0.5f;
    const std::vector<float> coordinates = {0,
                                            1e-30f,
                                            half,
                                            -half,
                                            std::nextafter(half, 0.0f), // adding a half rounds it up to 1
                                            std::nextafter(half, 1.0f),
                                            std::nextafter(-half, 0.0f),
                                            std::nextafter(-half, -1.0f),
                                            std::nextafter(1.5f, 0.0f),
                                            std::nextafter(-15.5f, 0.0f),
                                            std::nextafter(15.5f, 0.0f),
                                            7.4999995f,
                                            7.5f,
                                            -8.5f,
                                            3.14159274f};
    std::uint64_t number = 0;
    for (const float x : coordinates) {
        for (const float y : coordinates) {
            Particle particle{{x, y, -x}, {1e-38f * x, y, -3e30f}, 0, (number + 1) << Particle::kVoxelBits | number};
            const std::array<std::uint32_t, 2> words = {std::uint32_t(number * 65535) << 8 | 3, ~std::uint32_t(0)};
            particle.alive = Hits::pack(number * 65535, number + 1);
            const int leaf = domain->findLeaf(voxelOf(Float4{x, y, -x, 0}));
            ASSERT_GE(leaf, 0);
            bins.add(std::size_t(leaf), particle, words.data());
            expected[particle.id] = {particle, words};
            ++number;
        }
    }
    std::vector<ParticleBins> threads;
    threads.push_back(std::move(bins));
    const ParticleBins read = readAgain(*domain, threads, 2);
    std::size_t found = 0;
    for (std::size_t tile = 0; tile < domain->leafCount(); ++tile) {
        read.forEach(tile, [&](const Particle& particle, const std::uint32_t* words) {
            const auto& [same, sameWords] = expected.at(particle.id);
            EXPECT_EQ(particle.position, same.position);
            EXPECT_EQ(particle.slope, same.slope);
            EXPECT_EQ(particle.alive, same.alive);
            EXPECT_TRUE(std::equal(sameWords.begin(), sameWords.end(), words));
            const int leaf = domain->findLeaf(voxelOf(Float4{same.position[0], same.position[1], same.position[2], 0}));
            EXPECT_EQ(std::size_t(leaf), tile);
            ++found;
        });
    }
    EXPECT_EQ(found, expected.size());
}

TEST(ParticleGrid, MayBeEmpty)
{
    const auto domain = box({{0, 0, 0}, {3, 3, 3}});
    const ParticleBins read = readAgain(*domain, {}, 4);
    read.forEach(0, [](auto&&...) { ADD_FAILURE(); });
}

TEST(InputGrid, KeepsEveryValue)
{
    const auto domain = box({{0, 0, 0}, {63, 63, 31}}); // 2 x 65536 voxels
    LeafValues<std::int32_t> input(*domain, 0);
    for (std::size_t leaf = 0; leaf < domain->leafCount(); ++leaf) {
        for (std::size_t i = 0; i < Domain::kLeafVoxels; ++i) {
            const auto number = std::uint32_t(leaf * Domain::kLeafVoxels + i);
            input[leaf][i] = std::int32_t(number & 65535);
        }
    }
    const VdbFile file = throughAFile({inputGrid(*domain, domain->own(), input), particleGrid(*domain, {}, {})});
    FlowStateReader reader(*domain, 0, false);
    reader.add(file);
    const LeafValues<std::int32_t> read = reader.finish().input;
    for (std::size_t leaf = 0; leaf < domain->leafCount(); ++leaf)
        ASSERT_TRUE(std::equal(input[leaf], input[leaf] + Domain::kLeafVoxels, read[leaf]));
    const auto range = openvdb::tools::minMax(file.find<openvdb::FloatGrid>("noise")->tree());
    EXPECT_GE(range.min(), 0);
    EXPECT_LT(range.max(), 1);
}

TEST(SavedStates, ThatDoNotFitAreRefused)
{
    const auto frames = test::unsteadyFlowWithHole(4);
    const auto texture = makeFlowTexture({}, {NoiseField(7)});
    for (std::size_t k = 0; k < 2; ++k)
        (void)texture->advance(test::stepFrom(frames, k));
    const std::vector<VdbFile> state = throughFiles(*texture);
    const auto other = makeFlowTexture({}, {NoiseField(7)});
    EXPECT_NO_THROW(test::memoryOf(*other).restore(2, 1, frames[2].domain.texture, source(state)));
    EXPECT_THROW(test::memoryOf(*other).restore(2, 1, frames[3].domain.texture, source(state)), InputError);
    for (std::size_t missing = 0; missing < state.front().grids.size(); ++missing) {
        std::vector<VdbFile> part = state;
        part.front().grids.erase(part.front().grids.begin() + std::ptrdiff_t(missing));
        EXPECT_THROW(test::memoryOf(*other).restore(2, 1, frames[2].domain.texture, source(part)), InputError);
    }
    const auto window = makeFlowTexture({savedParams(&kAuflic2004, 4)}, {NoiseField(7)});
    EXPECT_THROW(test::memoryOf(*window).restore(2, 1, frames[2].domain.texture, source(state)), InputError);
}

TEST(SavedStates, OfLargeDomainsAreInParts)
{
    // One voxel thick: 65 x 65 leaves, more than a part has.
    const auto frames = test::makeFrames({Coord(0, 0, 0), Coord(519, 519, 0)}, 4, [](const Coord& at, int k) {
        return Vec3f(1.5f * std::sin(0.05f * float(at[1] + k)), 1.5f * std::cos(0.07f * float(at[0])), 0);
    });
    TextureParams scatter;
    scatter.substeps = 2; // with a running mean
    const auto texture = [&] { return makeFlowTexture({scatter}, {NoiseField(7)}); };
    const auto before = texture(), after = texture(), incomplete = texture();
    for (std::size_t k = 0; k < 2; ++k)
        (void)before->advance(test::stepFrom(frames, k));
    ASSERT_EQ(test::memoryOf(*before).parts(), 2u);
    openvdb::CoordBBox both = test::memoryOf(*before).save(0).box;
    both.expand(test::memoryOf(*before).save(1).box);
    EXPECT_EQ(both, openvdb::CoordBBox({0, 0, 0}, {519, 519, 7}));
    const std::vector<VdbFile> files = throughFiles(*before);
    test::memoryOf(*after).restore(2, 1, frames[2].domain.texture, source({files[1], files[0]})); // in any order
    EXPECT_EQ(differingVoxels(after->advance(test::stepFrom(frames, 2)).texture,
                              before->advance(test::stepFrom(frames, 2)).texture),
              0u);
    EXPECT_THROW(test::memoryOf(*incomplete).restore(2, 1, frames[2].domain.texture, source({files[1]})), InputError);
}

TEST(ParticleGrid, IsRefusedWithValuesThatNoRunLeaves)
{
    const auto domain = box({{0, 0, 0}, {7, 7, 7}});
    const auto readWith = [&](std::uint64_t alive) {
        std::vector<ParticleBins> bins;
        bins.emplace_back(domain->leafCount(), 0);
        bins.front().add(0, Particle{{1, 2, 3}, {0, 0, 0}, alive, 7}, nullptr);
        return readAgain(*domain, bins, 0);
    };
    std::uint64_t found = 0;
    readWith(Hits::pack(96 * 65535, 96)).forEach(0, [&](const Particle& particle, auto) { found = particle.alive; });
    EXPECT_EQ(found, Hits::pack(96 * 65535, 96));
    EXPECT_THROW(readWith(0), InputError);
    EXPECT_THROW(readWith(Hits::pack(96 * 65535 + 1, 96)), InputError); // brighter than white
    EXPECT_THROW(readWith(Hits::pack(0, Hits::kCountMask)), InputError);
}

TEST(FadingValues, LoseTheSameShareInEveryFrame)
{
    const auto withOneMore = [](std::uint64_t word, std::uint64_t value) {
        FadingValues::add(word, nullptr, value);
        return word;
    };
    for (const int life : {2, 4, 20, 1000}) {
        const std::uint64_t steady = FadingValues({.lifeSpan = life}, 0).atRelease(60000);
        const std::uint64_t again = FadingValues::faded(withOneMore(steady, 60000), std::uint64_t(life));
        EXPECT_NEAR(double(Hits::count(again)), double(Hits::count(steady)), 0.5) << life;
        EXPECT_EQ(Hits::sum(again), 60000 * Hits::count(again)) << life;
    }
    std::uint64_t word = Hits::pack(3000, 3000);
    for (int frame = 0; frame < 4; ++frame)
        word = FadingValues::faded(word, 4);
    EXPECT_NEAR(double(Hits::count(word)), 3000 * 16 / 81.0, 2); // two thirds stay
    EXPECT_EQ(FadingValues::faded(withOneMore(0, 5), 1), 0u);
    EXPECT_EQ(FadingValues({.lifeSpan = 1}, 0).atRelease(5), 0u);
    for (int frame = 0; frame < 40; ++frame) // nothing stays for ever
        word = word > 0 ? FadingValues::faded(word, 4) : 0;
    EXPECT_EQ(word, 0u);
}

} // namespace
} // namespace vdblic
