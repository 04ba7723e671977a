#include "cast/test_scene.h"
#include "distributed/thread_ranks.h"
#include "vdblic/cast/light_grid.h"
#include "vdblic/cast/picture_cuts.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/render_sequence.h"
#include "vdblic/render/view.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <mutex>
#include <sstream>

namespace vdblic {
namespace {

using openvdb::Coord;

/// A frame of a ball with tiles, beside it a hole and a voxel that is no number, and coarse values to be resampled.
class SharedFrames : public testing::Test {
  protected:
    SharedFrames()
    {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        mFolder = std::filesystem::path(testing::TempDir()) / (std::string("vdblic_shared_") + info->name());
        std::filesystem::remove_all(mFolder);
        std::filesystem::create_directories(mFolder);
        const auto texture = openvdb::FloatGrid::create();
        texture->setName("density");
        const auto magnitude = openvdb::FloatGrid::create();
        magnitude->setName("magnitude");
        const auto q = openvdb::FloatGrid::create();
        q->setName("q");
        q->setTransform(openvdb::math::Transform::createLinearTransform(3));
        for (auto c = openvdb::CoordBBox(Coord(-30), Coord(29)).begin(); c; ++c) {
            const double radius = (*c).asVec3d().length();
            if (radius > 30 || (radius < 12 && (*c).x() > 0)) continue;
            texture->tree().setValueOn(*c, scattered(*c));
            magnitude->tree().setValueOn(*c, float(radius + (*c).y()));
        }
        texture->tree().addTile(1, Coord(32, 0, 0), 0.7f, true);
        magnitude->tree().addTile(1, Coord(32, 0, 0), 20, true);
        texture->tree().setValueOn(Coord(-20, 3, 3), std::nanf(""));
        for (auto c = openvdb::CoordBBox(Coord(-11), Coord(12)).begin(); c; ++c)
            q->tree().setValueOn(*c, float((*c).x() - (*c).z()));
        writeVdb(mFolder / "t.vdb", {magnitude, texture, q}, {});
        mParams.input.pattern = mFolder / "t.vdb";
        mParams.picture.size = {93, 70};
        mParams.picture.camera.fieldOfView = 50;
    }
    ~SharedFrames() override { std::filesystem::remove_all(mFolder); }

    std::string bytesOf(const std::string& name)
    {
        std::ifstream file(mFolder / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    void render(const std::string& name, Reporter& reporter, Exchange& exchange)
    {
        RenderParams params = mParams;
        params.outputs.images = mFolder / name;
        std::istringstream none;
        renderSequence(resolve(params), none, reporter, exchange);
    }
    /// Ranks make the file that one process makes.
    void compare()
    {
        Reporter silent;
        OneProcess alone;
        render("one.exr", silent, alone);
        const std::string one = bytesOf("one.exr");
        ASSERT_FALSE(one.empty());
        for (const int ranks : {2, 3, 7}) {
            test::ThreadRanks(ranks).run([&](Exchange& exchange) {
                Reporter own;
                render("many.exr", own, exchange);
            });
            EXPECT_EQ(bytesOf("many.exr") == one, true) << ranks << " ranks";
            std::filesystem::remove(mFolder / "many.exr");
        }
    }

    std::filesystem::path mFolder;
    RenderParams mParams;
};

TEST_F(SharedFrames, SurfacesWithHalosAndAllLayers)
{
    mParams.picture.lookOptions["halo"] = {"1"};
    mParams.outputs.exr.layers = parseImageLayers({"all"});
    compare();
}

TEST_F(SharedFrames, LinesInsideTheVolume)
{
    mParams.picture.lookOptions["shading"] = {"lines"};
    mParams.picture.camera.eye = glm::dvec3(5, 2, 1);
    mParams.picture.camera.target = glm::dvec3(-20, 3, 7);
    compare();
}

TEST_F(SharedFrames, ShadowsSolidsCutsAndSeveralRays)
{
    mParams.picture.lookOptions["shadows"] = {"0.8"};
    mParams.picture.lookOptions["occlusion"] = {"0.6"};
    mParams.picture.solid = "domain";
    mParams.picture.samples = 3;
    mParams.picture.rays.clip.planes = {{{3, 0, 0}, {-1, 0.2, 0}}};
    mParams.picture.annotations.box = true;
    compare();
}

TEST_F(SharedFrames, AScalarOnItsOwnVoxelsARegionAndAStretch)
{
    mParams.picture.opacityBy = "q";
    mParams.picture.regionBox = {-20, -30, -30, 30, 30, 20};
    mParams.picture.stretch = {1, 1, 1.7};
    mParams.picture.camera.projection = Projection::kOrthographic;
    compare();
}

TEST_F(SharedFrames, TheFirstRankTellsWhatOneProcessTells)
{
    struct Told : Reporter {
        void warn(std::string_view message) override { text += std::string(message) + '\n'; }
        void finished(const std::filesystem::path& output) override { text += output.filename().string() + '\n'; }
        std::string text;
    };
    mParams.picture.camera.eye = glm::dvec3(900);
    mParams.picture.camera.target = glm::dvec3(1900);
    Told alone;
    OneProcess one;
    render("x.exr", alone, one);
    EXPECT_NE(alone.text.find("1 values are not finite"), std::string::npos) << alone.text;
    EXPECT_NE(alone.text.find("sees nothing"), std::string::npos) << alone.text;
    std::string told;
    test::ThreadRanks(3).run([&](Exchange& exchange) {
        Told mine;
        render("x.exr", mine, exchange);
        if (exchange.isFirst()) told = mine.text;
    });
    EXPECT_EQ(told, alone.text);
}

TEST_F(SharedFrames, RanksReadTheirPartsOnly)
{
    // Orthographic and without gradients, so that a part is little more than its share.
    const auto file = FrameFile{1, mFolder / "t.vdb"};
    mParams.picture.texture = "density";
    const PicturePlan plan = resolve(mParams.picture, {});
    const Corners box = LoadedTexture(loadFrame(plan, file)).box().corners();
    const Camera camera({.projection = Projection::kOrthographic}, box, {160, 160});
    const PictureCuts cuts(camera, box, 4);
    std::size_t owned = 0, had = 0, whole = 0;
    for (int rank = 0; rank < 4; ++rank) {
        const ViewShare share(cuts, rank, glm::dmat4(1));
        const LoadedTexture part = loadFrame(plan, file, nullptr, &share);
        whole = part.volume->domain().leafCount();
        had += part.volume->leafCount();
        std::size_t values = 0;
        for (auto leaf = part.texture->tree().cbeginLeaf(); leaf; ++leaf)
            values += !leaf->buffer().empty();
        EXPECT_LT(values, whole);
        for (std::size_t leaf = 0; leaf < part.volume->leafCount(); ++leaf)
            owned += part.volume->isOwn(leaf);
    }
    EXPECT_EQ(owned, whole);
    EXPECT_LT(had, 3 * whole);
}

TEST_F(SharedFrames, AnErrorAtOneRankEndsAll)
{
    std::ofstream(mFolder / "t.vdb", std::ios::binary) << bytesOf("t.vdb").substr(0, 9000);
    std::mutex mutex;
    int failed = 0;
    EXPECT_THROW(test::ThreadRanks(3).run([&](Exchange& exchange) {
        Reporter silent;
        try {
            render("x.exr", silent, exchange);
        } catch (const InputError& error) {
            const std::scoped_lock lock(mutex);
            failed += std::string(error.what()).find("t.vdb") != std::string::npos;
            throw;
        }
    }),
                 InputError);
    EXPECT_EQ(failed, 3);
    EXPECT_FALSE(std::filesystem::exists(mFolder / "x.exr"));
}

} // namespace
} // namespace vdblic
