#include "vdblic/render/render_sequence.h"

#include "cast/test_scene.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/render_plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <fstream>
#include <sstream>

namespace vdblic {
namespace {

using openvdb::Coord;

struct Recorder : Reporter {
    void say(std::string_view message) override { said.emplace_back(message); }
    void warn(std::string_view message) override { warned.emplace_back(message); }
    void finished(const std::filesystem::path& output) override { outputs.push_back(output.filename().string()); }

    std::vector<std::string> said, warned, outputs;
};

class RenderSequence : public testing::Test {
  protected:
    RenderSequence()
    {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        mFolder = std::filesystem::path(testing::TempDir()) / (std::string("vdblic_render_") + info->name());
        std::filesystem::remove_all(mFolder);
        std::filesystem::create_directories(mFolder);
        mParams.input.pattern = mFolder / "lic.%04d.vdb";
        mParams.outputs.images = mFolder / "image.%04d.png";
        mParams.picture.size = {40, 30};
    }
    ~RenderSequence() override { std::filesystem::remove_all(mFolder); }

    std::filesystem::path write(int frame, const openvdb::GridCPtrVec& grids)
    {
        auto path = mFolder / fmt::format("lic.{:04}.vdb", frame);
        writeVdb(path, grids, {});
        return path;
    }
    void writeBox(int frame, int size)
    {
        write(frame, {boxGrid("density", boxOf(size, size, size), scattered),
                      boxGrid("magnitude", boxOf(size, size, size), [](const Coord& c) { return float(c.x()); })});
    }
    Recorder render()
    {
        Recorder recorder;
        renderSequence(mParams, mLines, recorder);
        return recorder;
    }

    /// The displayed red, green and blue bytes of an image.
    std::vector<png_byte> pixels(const std::string& name)
    {
        png_image png{};
        png.version = PNG_IMAGE_VERSION;
        EXPECT_TRUE(png_image_begin_read_from_file(&png, (mFolder / name).c_str())) << png.message;
        std::vector<png_byte> bytes(PNG_IMAGE_SIZE(png));
        EXPECT_TRUE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr)) << png.message;
        return bytes;
    }

    std::filesystem::path mFolder;
    RenderParams mParams;
    std::istringstream mLines;
};

TEST_F(RenderSequence, FollowsTheInputsFrames)
{
    for (const int frame : {3, 5, 7})
        writeBox(frame, 12);
    EXPECT_EQ(render().outputs, (std::vector<std::string>{"image.0003.png", "image.0005.png", "image.0007.png"}));
    mParams.input.frames = "5";
    EXPECT_EQ(render().outputs, std::vector<std::string>{"image.0005.png"});
}

TEST_F(RenderSequence, CameraAndLookStayThoseOfTheFirstFrameThatShowsSomething)
{
    write(1, {openvdb::FloatGrid::create()});
    writeBox(2, 16);
    writeBox(3, 8);                     // of another size, with other values of the driver
    EXPECT_THROW(render(), InputError); // frame 1 has no grid of the name
    const auto empty = openvdb::FloatGrid::create();
    empty->setName("density");
    write(1, {empty});
    ASSERT_EQ(render().outputs.size(), 3u);

    const std::vector<png_byte> nothing = pixels("image.0001.png");
    for (std::size_t i = 0; i < nothing.size(); ++i)
        EXPECT_EQ(nothing[i], nothing[i % 3]);
    EXPECT_NE(pixels("image.0002.png"), nothing);

    // A machine that renders the third frame alone makes the same picture. As a sequence of its own the frame would
    // look different.
    const std::vector<png_byte> followed = pixels("image.0003.png");
    mParams.input.frames = "3";
    render();
    EXPECT_EQ(followed, pixels("image.0003.png"));
    mParams.input = {mFolder / "lic.0003.vdb"};
    render();
    EXPECT_NE(followed, pixels("image.0003.png"));
}

/// Names that no small string holds, each of its own file.
TEST_F(RenderSequence, EachFileNamesItsTexture)
{
    mParams.keepGoing = true;
    for (int frame = 1; frame <= 6; ++frame) {
        const std::string name = fmt::format("a texture with the long name {}", frame);
        openvdb::MetaMap metadata;
        metadata.insertMeta(kTextureKey, openvdb::StringMetadata(name));
        const auto other = boxGrid("density", boxOf(3, 3, 3), scattered);
        writeVdb(mFolder / fmt::format("lic.{:04}.vdb", frame), {other, boxGrid(name, boxOf(12, 12, 12), scattered)},
                 metadata);
    }
    const Recorder found = render();
    EXPECT_EQ(found.outputs.size(), 6u);
    EXPECT_EQ(found.warned, std::vector<std::string>{});
    for (int frame = 2; frame <= 6; ++frame)
        EXPECT_EQ(pixels(fmt::format("image.{:04}.png", frame)), pixels("image.0001.png"));
}

/// Of a sparse texture, whose scalars lie on coarser voxels.
TEST_F(RenderSequence, WhatIsWrittenBesideAPictureDoesNotChangeIt)
{
    openvdb::MetaMap metadata;
    metadata.insertMeta(kInactiveKey, openvdb::StringMetadata(kEmpty));
    const auto texture = boxGrid("density", boxOf(24, 24, 24), scattered);
    texture->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    texture->transform().postTranslate(openvdb::Vec3d(-0.25));
    const auto speed = boxGrid("magnitude", boxOf(12, 12, 12), [](const Coord& c) { return float(c.x() * c.y() % 7); });
    writeVdb(mFolder / "lic.0001.vdb", {texture, speed}, metadata);
    render();
    const std::vector<png_byte> alone = pixels("image.0001.png");
    mParams.outputs.histogram = mFolder / "histogram.json";
    mParams.outputs.transferFunction = mFolder / "transfer.json";
    EXPECT_EQ(render().outputs.size(), 3u);
    EXPECT_EQ(pixels("image.0001.png"), alone);
}

TEST_F(RenderSequence, TheCameraSeesAllFrames)
{
    // A box that moves: the voxels of later frames lie outside those of the first.
    for (const int frame : {1, 2, 3}) {
        const openvdb::CoordBBox box(Coord(frame * 40, 0, 0), Coord(frame * 40 + 9, 9, 9));
        const auto grid = boxGrid("density", box, scattered);
        write(frame, {grid});
    }
    mParams.picture.lookOptions = {{"opacity", {"0:0.9"}}, {"modulate", {"0"}}, {"background", {"0", "0", "0"}}};
    render();
    const auto lit = [&](const std::vector<png_byte>& bytes, int x) {
        for (int y = 0; y < 30; ++y) {
            for (int channel = 0; channel < 3; ++channel) {
                if (bytes[(std::size_t(y) * 40 + std::size_t(x)) * 3 + std::size_t(channel)] > 0) return true;
            }
        }
        return false;
    };
    for (const int frame : {1, 2, 3}) {
        const auto bytes = pixels(fmt::format("image.{:04}.png", frame));
        int columns = 0;
        for (int x = 0; x < 40; ++x)
            columns += lit(bytes, x);
        EXPECT_GT(columns, 3) << frame;
        EXPECT_LT(columns, 20) << frame;
        EXPECT_FALSE(lit(bytes, 0) || lit(bytes, 39)) << frame;
    }
}

TEST_F(RenderSequence, WhatIsFinishedIsReportedThoughAFrameIsBad)
{
    for (const int frame : {1, 2, 3, 4, 5})
        writeBox(frame, 12);
    std::filesystem::resize_file(mFolder / "lic.0003.vdb", 400);
    Recorder recorder;
    EXPECT_THROW(renderSequence(mParams, mLines, recorder), InputError);
    std::vector<std::string> finished;
    for (const int frame : {1, 2, 3, 4, 5}) {
        const std::string name = fmt::format("image.{:04}.png", frame);
        if (std::filesystem::exists(mFolder / name)) finished.push_back(name);
    }
    EXPECT_EQ(recorder.outputs, finished);
    ASSERT_GE(finished.size(), 2u); // frames before the bad one in any case
    EXPECT_EQ(finished[1], "image.0002.png");
}

TEST_F(RenderSequence, AFrameThatComesTwiceIsRefused)
{
    writeBox(4, 10);
    std::filesystem::create_directory(mFolder / "other");
    std::filesystem::copy(mFolder / "lic.0004.vdb", mFolder / "other" / "lic.0004.vdb");
    mParams.input.pattern = "-";
    mLines.str(fmt::format("{0}/lic.0004.vdb\n{0}/other/lic.0004.vdb\n", mFolder.string()));
    try {
        render();
        FAIL() << "the first image was overwritten";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("other/lic.0004.vdb"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("frame 4"), std::string::npos) << error.what();
    }
}

TEST_F(RenderSequence, SkippedFramesStillDecideTheLook)
{
    for (const int frame : {1, 2})
        writeBox(frame, 10 * frame);
    mParams.input.pattern = "-";
    mParams.outputs.skipExisting = true;
    const std::string lines = fmt::format("{0}/lic.0001.vdb\n{0}/lic.0002.vdb\n", mFolder.string());
    mLines.str(lines);
    render();
    const auto whole = pixels("image.0002.png");
    std::filesystem::remove(mFolder / "image.0002.png");
    mLines = std::istringstream(lines);
    EXPECT_EQ(render().outputs, (std::vector<std::string>{"image.0001.png", "image.0002.png"}));
    EXPECT_EQ(pixels("image.0002.png"), whole);
}

TEST_F(RenderSequence, HistogramsCountTheVoxelsOfAllFrames)
{
    for (const int frame : {1, 2})
        writeBox(frame, 10);
    mParams.outputs.images.clear();
    mParams.outputs.histogram = mFolder / "h.json";
    EXPECT_EQ(render().outputs, std::vector<std::string>{"h.json"});
    EXPECT_FALSE(std::filesystem::exists(mFolder / "image.0001.png"));
    std::stringstream text;
    text << std::ifstream(mFolder / "h.json").rdbuf();
    EXPECT_NE(text.str().find("\"voxels\": 2000"), std::string::npos) << text.str();
    mParams.outputs.histogram = mFolder / "h.svg";
    EXPECT_THROW(render(), ParameterError);
}

TEST_F(RenderSequence, ReadsPathsFromItsInput)
{
    writeBox(4, 10);
    writeBox(9, 10);
    mParams.input.pattern = "-";
    mLines.str(fmt::format("{0}/lic.0009.vdb\n{0}/lic.0004.vdb\n", mFolder.string()));
    EXPECT_EQ(render().outputs, (std::vector<std::string>{"image.0009.png", "image.0004.png"}));
}

TEST_F(RenderSequence, OneOutputIsNotWrittenTwice)
{
    writeBox(4, 10);
    writeBox(9, 10);
    mParams.outputs.images = mFolder / "image.png";
    EXPECT_THROW(render(), ParameterError);
    EXPECT_FALSE(std::filesystem::exists(mFolder / "image.png"));
    mParams.input.pattern = "-";
    mLines.str(fmt::format("{0}/lic.0009.vdb\n{0}/lic.0004.vdb\n", mFolder.string()));
    EXPECT_THROW(render(), ParameterError);
}

TEST_F(RenderSequence, SaysOnceThatThereIsNoDriver)
{
    for (const int frame : {1, 2})
        write(frame, {boxGrid("fog", boxOf(12, 12, 12), scattered)});
    mParams.picture.texture = "fog";
    const Recorder recorder = render();
    ASSERT_EQ(recorder.said.size(), 1u);
    EXPECT_NE(recorder.said[0].find("magnitude"), std::string::npos);
    EXPECT_TRUE(recorder.warned.empty());
}

TEST_F(RenderSequence, WarnsOfVoxelsThatAreNoNumbers)
{
    const auto grid = boxGrid("density", boxOf(12, 12, 12), scattered);
    grid->tree().setValueOn({4, 4, 4}, std::nanf(""));
    write(1, {grid});
    const Recorder recorder = render();
    ASSERT_EQ(recorder.warned.size(), 1u);
    EXPECT_NE(recorder.warned[0].find("1 values"), std::string::npos);
}

TEST_F(RenderSequence, NamesFileAndGridOfABadInput)
{
    const auto grid = boxGrid("density", boxOf(4, 4, 4), scattered);
    grid->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(9)), 0.5, 10, 0.1));
    write(1, {grid});
    try {
        render();
        FAIL() << "a frustum was taken";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("lic.0001.vdb"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("density"), std::string::npos) << error.what();
    }
}

TEST_F(RenderSequence, RefusesBadParametersBeforeAnyWork)
{
    const auto refuses = [&](auto change) {
        RenderParams params = mParams;
        change(params);
        EXPECT_THROW((void)resolve(params), ParameterError);
    };
    refuses([](RenderParams& p) { p.outputs.images = "image.jpg"; });
    refuses([](RenderParams& p) { p.picture.size = {0, 10}; });
    refuses([](RenderParams& p) { p.picture.size = {10, 100000}; });
    refuses([](RenderParams& p) { p.picture.samples = 0; });
    refuses([](RenderParams& p) { p.picture.lookOptions["modulate"] = {"-0.1"}; });
    refuses([](RenderParams& p) { p.picture.lookOptions["head_light"] = {"nan"}; });
    refuses([](RenderParams& p) { p.picture.rays.step = 0; });
    refuses([](RenderParams& p) { p.picture.camera.fieldOfView = 400; });
    refuses([](RenderParams& p) { p.picture.lookOptions["background_alpha"] = {"2"}; });
    refuses([](RenderParams& p) { p.outputs.images.clear(); });
    refuses([](RenderParams& p) { p.outputs.exr.layers = {ImageLayer::kDepth}; }); // not in a .png
    refuses([](RenderParams& p) { p.picture.motion.orbit = std::nan(""); });
    refuses([](RenderParams& p) {
        p.picture.motion.orbit = 1;
        p.input.pattern = "-";
    });
}

} // namespace
} // namespace vdblic
