#include "view/pictures.h"

#include "cast/test_scene.h"
#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/reporter.h"
#include "vdblic/io/vdb_file.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <latch>
#include <optional>
#include <string>
#include <thread>

namespace vdblic::view {
namespace {

using Json = nlohmann::json;
using openvdb::Coord;

bool here()
{
    return false;
}

class ShownPictures : public testing::Test {
  protected:
    ShownPictures()
    {
        const auto magnitude = boxGrid("magnitude", boxOf(12, 10, 8), [](const Coord& c) { return float(c.x() + 1); });
        for (const char* name : {"lic.1.vdb", "lic.2.vdb"})
            writeVdb(mFolder / name, {boxGrid("density", boxOf(12, 10, 8), scattered), magnitude}, {});
        mViewer.emplace(Start{{.pattern = (mFolder / "lic.%d.vdb").string()}, {}, Json::object(), {}}, 1e9);
        mPictures.emplace(*mViewer);
    }

    ShownPicture ask(const PictureRequest& request) { return mPictures->picture(request, here); }
    /// Whether a request is told to end.
    bool isStopped(const PictureRequest& request)
    {
        try {
            (void)ask(request);
            return false;
        } catch (const Stopped&) {
            return true;
        }
    }
    static PictureRequest request(const std::string& client, int samples, std::optional<std::int64_t> turn = {})
    {
        return {client, turn, Json{{"size", {24, 16}}, {"samples", samples}}, 1, true};
    }

    TemporaryFolder mFolder;
    std::optional<Viewer> mViewer;
    std::optional<Pictures> mPictures;
};

TEST_F(ShownPictures, FurtherSamplesContinueAPicture)
{
    const ShownPicture one = ask(request("a", 1)), two = ask(request("a", 2)), five = ask(request("a", 5));
    EXPECT_EQ(one.samples, 1);
    EXPECT_EQ(five.samples, 5);
    EXPECT_TRUE(five.settled);
    EXPECT_EQ(five.image.size, glm::ivec2(24, 16));
    EXPECT_EQ(difference(five.image, ask(request("b", 5)).image), 0);
    EXPECT_GT(difference(one.image, two.image), 0);
    // Fewer begin anew.
    EXPECT_EQ(difference(one.image, ask(request("a", 1)).image), 0);
}

TEST_F(ShownPictures, AnOlderRequestThatArrivesLateEnds)
{
    EXPECT_FALSE(isStopped(request("a", 1, 1)));
    EXPECT_FALSE(isStopped(request("a", 1, 3)));
    EXPECT_TRUE(isStopped(request("a", 1, 2)));
    EXPECT_FALSE(isStopped(request("a", 1, 3)));
    EXPECT_FALSE(isStopped(request("b", 1, 1))); // somebody else
    EXPECT_FALSE(isStopped(request("a", 1)));    // the newest, as it says nothing else
}

TEST_F(ShownPictures, ANewerRequestEndsAnOlderOne)
{
    std::latch isCast(1);
    std::atomic<bool> stopped = false;
    std::thread older([&] {
        int asked = 0;
        try {
            PictureRequest slow = request("a", 4000, 1);
            slow.state["size"] = {800, 600};
            (void)mPictures->picture(slow, [&] {
                if (++asked == 4) isCast.count_down(); // twice before the first sample
                return false;
            });
        } catch (const Stopped&) {
            stopped = true;
        }
    });
    isCast.wait();
    EXPECT_EQ(ask(request("b", 1)).samples, 1); // somebody else
    EXPECT_FALSE(stopped);
    EXPECT_EQ(ask(request("a", 1, 2)).samples, 1);
    older.join();
    EXPECT_TRUE(stopped);
}

TEST_F(ShownPictures, AClientThatGoesAwayIsNotCastFor)
{
    int asked = 0;
    EXPECT_THROW((void)mPictures->picture(request("a", 4000), [&] { return ++asked == 6; }), Stopped);
    EXPECT_EQ(asked, 6);
    EXPECT_EQ(ask(request("a", 2)).samples, 2);
}

TEST_F(ShownPictures, ImpossibleRequestsAreRefused)
{
    PictureRequest bad = request("a", 1);
    bad.frame = 7;
    EXPECT_THROW((void)ask(bad), ParameterError);
    bad = request("a", 1);
    bad.state["size"] = {9000, 10};
    EXPECT_THROW((void)ask(bad), ParameterError);
    bad.state = {{"look", "sepia"}};
    EXPECT_THROW((void)ask(bad), ParameterError);
    bad.state = {{"size", {24, 16}}, {"by", "q"}};
    EXPECT_THROW((void)ask(bad), InputError);
    EXPECT_EQ(ask(request("a", 1)).samples, 1);
}

TEST_F(ShownPictures, AnEmptyPictureSaysWhy)
{
    PictureRequest away = request("a", 1);
    EXPECT_EQ(ask(away).nothingSeen, "");
    away.state["eye"] = {0, 0, 100};
    away.state["target"] = {0, 0, 200};
    EXPECT_NE(ask(away).nothingSeen, "");
}

} // namespace
} // namespace vdblic::view
