#include "vdblic/methods/registry.h"

#include "methods/test_flow.h"
#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/field/synth.h"
#include "vdblic/io/vdb_header.h"
#include "vdblic/run/advect.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <set>
#include <sstream>
#include <string_view>

namespace vdblic {
namespace {

/// The least that a method is: every voxel is white, and nothing is remembered.
class WhiteTexture final : public FlowTexture {
  public:
    [[nodiscard]] TextureFrame advance(const FlowStep& step) override
    {
        TextureFrame result(step);
        result.texture = {*result.domain, 1.0f};
        return result;
    }
    [[nodiscard]] Lengths<Space::kTexture> farthestPath(const Speeds<Space::kTexture, Per::kFrame>& /*fastest*/,
                                                        double /*seconds*/) const override
    {
        return {};
    }
};

constinit const TextureMethod kWhite{
    .name = "white",
    .text = "white everywhere",
    .preroll = [](const MethodParams& /*params*/) { return 0; },
    .leadIn = [](const MethodParams& /*params*/) { return 0; },
    .make = [](const MethodParams& /*params*/, MethodInput&& /*input*/) -> std::unique_ptr<FlowTexture> {
        return std::make_unique<WhiteTexture>();
    },
    .describe = [](const MethodParams& /*params*/, openvdb::MetaMap& /*metadata*/) {},
    .bytes = [](const MethodParams& /*params*/, const FrameDomain& /*first*/, const Refinement& /*given*/,
                bool /*withHits*/) { return 1e6; },
};

TEST(TextureMethods, AreFoundByTheirNames)
{
    std::set<std::string_view> names;
    for (const TextureMethod* const method : textureMethods()) {
        EXPECT_EQ(&textureMethod(method->name), method);
        names.insert(method->name);
    }
    EXPECT_EQ(names.size(), 8u);
    try {
        (void)textureMethod("white");
        FAIL();
    } catch (const ParameterError& error) {
        EXPECT_STREQ(error.what(), "'white' is none of auflic, auflic-2004, uflic, lic, streaks, ibfv, lea, ufac");
    }
}

TEST(TextureMethods, MakeTheTexturesOfTheirOwnName)
{
    const auto frames = test::unsteadyFlowWithHole(3);
    for (const TextureMethod* const method : textureMethods()) {
        const auto texture = makeFlowTexture({{.method = method}}, {NoiseField(7)});
        auto* const sparse = dynamic_cast<AdaptiveTexture*>(texture.get());
        EXPECT_EQ(sparse != nullptr, method->isSparse) << method->name;
        if (sparse) (void)sparse->choose(*frames.front().domain.texture, 1);
        EXPECT_GT(texture->advance(test::stepFrom(frames, 0)).texture.tree()->activeVoxelCount(), 0u) << method->name;
        EXPECT_EQ(dynamic_cast<const TextureMemory*>(texture.get()) == nullptr, method->isSteady) << method->name;
    }
}

TEST(TextureMethods, RunThoughAProgramBringsThem)
{
    const TemporaryFolder folder;
    Reporter silent;
    synthSequence(
        {.flow = "tornado", .output = (folder / "v.%04d.vdb").string(), .size = {{12, 12, 12}}, .frames = "1-3"},
        silent);
    AdvectParams params;
    params.flow.input.pattern = (folder / "v.%04d.vdb").string();
    params.output = (folder / "white.%04d.vdb").string();
    params.texture.method = &kWhite;
    std::istringstream noPaths;
    advectSequence(params, noPaths, silent);
    const openvdb::MetaMap metadata = readVdbHeader(folder / "white.0003.vdb").metadata;
    EXPECT_EQ(metadata["method"]->str(), "white");
}

} // namespace
} // namespace vdblic
