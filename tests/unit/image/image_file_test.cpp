#include "vdblic/image/image_file.h"

#include "vdblic/core/errors.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <cmath>
#include <map>

namespace vdblic {
namespace {

/// A row of a few pixels that are exact in half precision.
Image sample()
{
    return {
        {3, 2},
        {{0, 0, 0, 0}, {0.25f, 0.5f, 0.125f, 0.5f}, {1, 1, 1, 1}, {4, 0, 0, 1}, {0, 0.5f, 0, 0.5f}, {0.5f, 0, 0, 1}}};
}

class ImageFile : public testing::Test {
  protected:
    ImageFile()
    {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        mFolder = std::filesystem::path(testing::TempDir()) / (std::string("vdblic_image_") + info->name());
        std::filesystem::remove_all(mFolder);
        std::filesystem::create_directories(mFolder);
    }
    ~ImageFile() override { std::filesystem::remove_all(mFolder); }

    std::filesystem::path mFolder;
};

TEST_F(ImageFile, ExrHoldsWhatWasRendered)
{
    ImageHeader header;
    header.attributes = {{"frame", 7}, {"step", 0.5f}, {"colorMap", std::string("turbo")}, {"eye", glm::vec3(1, 2, 3)}};
    header.worldToCamera[3] = {10, 20, 30, 1}; // a translation
    header.screenWindowWidth = 0.75f;
    const std::string path = mFolder / "a.exr";
    writeImage(path, sample(), header, {});

    Imf::RgbaInputFile file(path.c_str());
    EXPECT_EQ(file.dataWindow(), Imath::Box2i({0, 0}, {2, 1}));
    EXPECT_EQ(file.compression(), Imf::ZIP_COMPRESSION);
    std::vector<Imf::Rgba> pixels(6);
    file.setFrameBuffer(pixels.data(), 1, 3);
    file.readPixels(0, 1);
    const Image image = sample();
    for (std::size_t i = 0; i < 6; ++i) {
        const Imf::Rgba& p = pixels[i];
        EXPECT_EQ(glm::vec4(p.r, p.g, p.b, p.a), image.pixels[i]) << i;
    }
    EXPECT_EQ(file.header().findTypedAttribute<Imf::StringAttribute>("colorMap")->value(), "turbo");
    EXPECT_EQ(file.header().findTypedAttribute<Imf::StringAttribute>("creator")->value().substr(0, 7), "VDBLIC ");
    EXPECT_EQ(file.header().screenWindowWidth(), 0.75f);
    EXPECT_EQ(Imath::V3f(1, 1, 1) * Imf::worldToCamera(file.header()), Imath::V3f(11, 21, 31));
}

TEST_F(ImageFile, ExrLiesOverTheBackgroundAsFarAsThatIsOpaque)
{
    const std::string path = mFolder / "a.exr";
    writeImage(path, sample(), {}, {.color = glm::dvec3(1, 0, 1), .alpha = 0.5});
    Imf::RgbaInputFile file(path.c_str());
    std::vector<Imf::Rgba> pixels(6);
    file.setFrameBuffer(pixels.data(), 1, 3);
    file.readPixels(0, 1);
    const auto expectPixel = [&](std::size_t i, float r, float g, float b, float a) {
        EXPECT_EQ(glm::vec4(pixels[i].r, pixels[i].g, pixels[i].b, pixels[i].a), glm::vec4(r, g, b, a)) << i;
    };
    expectPixel(0, 0.5f, 0, 0.5f, 0.5f);
    expectPixel(1, 0.5f, 0.5f, 0.375f, 0.75f);
    expectPixel(2, 1, 1, 1, 1);
}

TEST_F(ImageFile, ExrHoldsTheLayersThatAreAskedFor)
{
    Image image = sample();
    image.layers.resize(6);
    image.layers[4] = {.depth = 70000, .normal = {0, 0.6f, -0.8f}, .driver = 1e6f, .texture = 0.3f, .samples = 70001};
    const std::string path = mFolder / "a.exr";
    writeImage(path, image, {}, {.alpha = 1}, {.precision = "float", .layers = parseImageLayers({"all"})});

    Imf::InputFile file(path.c_str());
    const auto type = [&](const char* name) { return file.header().channels()[name].type; };
    EXPECT_EQ(type("R"), Imf::FLOAT);
    EXPECT_EQ(type("samples"), Imf::FLOAT);
    Imf::FrameBuffer frame;
    std::map<std::string, std::array<float, 6>> values;
    for (const char* name : {"Z", "N.X", "N.Y", "N.Z", "magnitude", "texture", "samples", "A"}) {
        frame.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values[name].data()), 4, 12));
    }
    file.setFrameBuffer(frame);
    file.readPixels(0, 1);
    EXPECT_EQ(values["Z"][4], 70000);
    EXPECT_TRUE(std::isinf(values["Z"][0]));
    EXPECT_EQ(values["N.Y"][4], 0.6f);
    EXPECT_EQ(values["N.Z"][4], -0.8f);
    EXPECT_EQ(values["magnitude"][4], 1e6f);
    EXPECT_EQ(values["texture"][4], 0.3f);
    EXPECT_EQ(values["A"][4], 1); // the background affects colour and alpha only
    EXPECT_EQ(values["samples"][4], 70001);

    writeImage(path, image, {}, {}, {.layers = parseImageLayers({"depth"})});
    Imf::InputFile depthOnly(path.c_str());
    EXPECT_NE(depthOnly.header().channels().findChannel("Z"), nullptr);
    EXPECT_EQ(depthOnly.header().channels().findChannel("N.X"), nullptr);
}

TEST_F(ImageFile, ExrSaysItsColorsAreRec709)
{
    const std::string path = mFolder / "a.exr";
    writeImage(path, sample(), {}, {});
    Imf::InputFile file(path.c_str());
    ASSERT_TRUE(Imf::hasChromaticities(file.header()));
    EXPECT_EQ(Imf::chromaticities(file.header()).red, Imath::V2f(0.64f, 0.33f));
    EXPECT_EQ(Imf::chromaticities(file.header()).white, Imath::V2f(0.3127f, 0.3290f));
}

TEST(ExrParams, RefuseUnknownNames)
{
    EXPECT_THROW((ExrParams{.precision = "double"}.validate()), ParameterError);
    EXPECT_THROW((void)parseImageLayers({"depth", "albedo"}), ParameterError);
    EXPECT_EQ(parseImageLayers({"all"}).size(), 5u);
    EXPECT_TRUE(parseImageLayers({}).empty());
}

TEST_F(ImageFile, PngIsOpaqueAndAsDisplayed)
{
    const std::string path = mFolder / "a.png";
    writeImage(path, sample(), {}, {.color = glm::dvec3(1, 0.5, 0)});
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_file(&png, path.c_str())) << png.message;
    EXPECT_EQ(png.width, 3u);
    EXPECT_EQ(png.height, 2u);
    EXPECT_EQ(png.format, unsigned(PNG_FORMAT_RGB));
    std::vector<png_byte> bytes(18);
    ASSERT_TRUE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr)) << png.message;
    // 0.214 of the light is displayed as one half; 0.735 as 0.874. Red of four times the most that can be displayed
    // gets a share of white, 0.45 / 1.45.
    const int expected[] = {255, 128, 0, 225, 203, 99, 255, 255, 255, 255, 151, 151, 188, 203, 0, 188, 0, 0};
    for (std::size_t i = 0; i < 18; ++i)
        EXPECT_NEAR(bytes[i], expected[i], 1) << i;
}

TEST_F(ImageFile, AFailureLeavesNothing)
{
    EXPECT_THROW(writeImage(mFolder / "missing" / "a.exr", sample(), {}, {}), OutputError);
    EXPECT_THROW(writeImage(mFolder / "a.jpg", sample(), {}, {}), ParameterError);
    EXPECT_TRUE(std::filesystem::is_empty(mFolder));
}

TEST(Image, FormatFollowsTheExtension)
{
    EXPECT_EQ(imageFormat("a/b.%04d.exr"), ImageFormat::kExr);
    EXPECT_EQ(imageFormat("b.png"), ImageFormat::kPng);
    for (const char* bad : {"b.jpg", "b", "exr", "b.png.txt", ""})
        EXPECT_THROW((void)imageFormat(bad), ParameterError) << bad;
}

TEST(Image, RefusesABackgroundThatIsNoColor)
{
    for (const double bad : {-0.1, 1.1, std::nan("")}) {
        EXPECT_THROW((Background{.color = glm::dvec3(0, bad, 0)}.validate()), ParameterError);
        EXPECT_THROW((Background{.alpha = bad}.validate()), ParameterError);
    }
}

} // namespace
} // namespace vdblic
