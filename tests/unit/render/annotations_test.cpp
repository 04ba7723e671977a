#include "vdblic/render/annotations.h"

#include "cast/test_scene.h"
#include "vdblic/core/errors.h"
#include "vdblic/image/image_file.h"
#include "vdblic/render/annotated_box.h"
#include "vdblic/render/annotation_font.h"
#include "vdblic/render/annotation_scale.h"
#include "vdblic/render/annotation_texts.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>

namespace vdblic {
namespace {

TEST(Annotations, TextIsReadBack)
{
    for (const char* text : {"box", "axes,time", "box,axes,colorbar,time,scalebar,triad,title=A, b = c",
                             "place=13.4 52.5 Berlin,place=-30 0 a b,title=c"})
        EXPECT_EQ(annotationText(parseAnnotations(text)), text);
    for (const char* bad : {"", "box,", "frame", "title", "title=", "box time", "place=", "place=1 2", "place=1 a b",
                            "place=1 91 a", "place=nan 0 a"})
        EXPECT_THROW((void)parseAnnotations(bad), ParameterError) << bad;
}

TEST(Annotations, TicksAreRound)
{
    double step = 0;
    EXPECT_EQ(roundNumbers(0.02, 0.28, 5, step).size(), 5u);
    EXPECT_EQ(tickText(0.05, step), "0.05");
    EXPECT_EQ(roundNumbers(-3, 7, 5, step), (std::vector<double>{-2, 0, 2, 4, 6}));
    EXPECT_EQ(tickText(-2, step), "-2");
    EXPECT_EQ(tickText(5.5e6, 5e5), "5.5e+06");
}

TEST(Annotations, AClockTellsDatesOrHours)
{
    const auto text = [](double time, std::optional<double> dt, const char* start = "") {
        return clockText({time, dt, start});
    };
    EXPECT_EQ(text(10800, 10800), "3 h");
    EXPECT_EQ(text(32400, 3600), "9 h");
    EXPECT_EQ(text(194400, 3600), "2 d 06 h");
    EXPECT_EQ(text(0, 3600), "0 h");
    EXPECT_EQ(text(5400, 1800), "1 h 30 min");
    EXPECT_EQ(text(3979, 568.421), "1 h 06 min 19 s");
    EXPECT_EQ(text(266400, 3600), "3 d 02 h");
    EXPECT_EQ(text(0.05, 0.05), "0.05 s");
    EXPECT_EQ(text(1, 0.05), "1.00 s");
    EXPECT_EQ(text(1.0 / 24, 1.0 / 24), "0.042 s");
    EXPECT_EQ(text(-2.5, 0.5), "-2.5 s");
    EXPECT_EQ(text(200, 0.5), "3 min 20.0 s");
    EXPECT_EQ(text(1.2, 0.05), "1.20 s");
    EXPECT_EQ(text(0.0324, 0.0001), "32.4 ms");
    EXPECT_EQ(text(2e-4, 1e-4), "0.2 ms");
    EXPECT_EQ(text(3e-7, 1e-7), "0.3 µs");
    EXPECT_EQ(text(0.5, {}), "0.5 s");
    EXPECT_EQ(text(10800, 10800, "2005-08-28T12:00:00"), "2005-08-28 15:00");
    EXPECT_EQ(text(43200, 3600, "2005-12-31T12:00:00"), "2006-01-01 00:00");
    EXPECT_EQ(text(90, 10, "2005-08-28 12:00:00Z"), "2005-08-28 12:01:30");
    EXPECT_EQ(text(0, 86400, "2005-08-28"), "2005-08-28 00:00");
    for (const char* bad : {"", "yesterday", "2005-02-30T00:00:00", "2005-08-28T25:00:00", "2005-08"})
        EXPECT_EQ(text(60, 60, bad), "1 min") << bad;
    EXPECT_EQ(clockText({}), "");
    EXPECT_EQ(text(1e300, 1), "");
}

TEST(Annotations, TimesOfASequenceAreWrittenAlike)
{
    const auto text = [](double time, double dt, double longest) { return clockText({time, dt, {}, longest}); };
    EXPECT_EQ(text(0, 3600, 82800), "\u20070 h");
    EXPECT_EQ(text(82800, 3600, 82800), "23 h");
    EXPECT_EQ(text(3600, 3600, 10 * 86400), "\u20070 d 01 h");
    EXPECT_EQ(text(600, 600, 7200), "0 h 10 min");
    EXPECT_EQ(text(0.5, 0.5, 12), "\u20070.5 s");
    EXPECT_EQ(text(12, 0.5, 12), "12.0 s");
    EXPECT_EQ(text(-1, 0.5, 12), "\u2007-1.0 s");
    EXPECT_EQ(text(20, 0.5, 180), "0 min 20.0 s");
    EXPECT_EQ(paddedText(7, 120), "\u2007\u20077");
    EXPECT_EQ(paddedText(7, 0), "7");
}

TEST(Annotations, LengthsHaveUnits)
{
    EXPECT_EQ(lengthText(2e5, "m"), "200 km");
    EXPECT_EQ(lengthText(1000, "m"), "1 km");
    EXPECT_EQ(lengthText(0.005, "m"), "5 mm");
    EXPECT_EQ(lengthText(2e-5, "m"), "20 µm");
    EXPECT_EQ(lengthText(20, "ft"), "20 ft");
    EXPECT_EQ(lengthText(0.5, ""), "0.5");
    EXPECT_EQ(lengthText(2e5, ""), "200\u202f000");
    EXPECT_EQ(lengthText(2e3, "ft"), "2000 ft");
    EXPECT_EQ(lengthText(5e6, "ft"), "5\u202f000\u202f000 ft");
    EXPECT_EQ(lengthText(0.002, ""), "0.002");
    EXPECT_EQ(lengthText(2e10, ""), "20 × 10⁹");
}

TEST(Annotations, AScaleBarHasARoundLengthAtTheTarget)
{
    Corners box;
    for (std::size_t i = 0; i < 8; ++i)
        box[i] = 100.0 * glm::dvec3(double(i & 1), double(i >> 1 & 1), double(i >> 2));
    // 300 pixels are 75 units.
    const Camera flat({.projection = Projection::kOrthographic, .eye = glm::dvec3(50, -200, 50), .viewHeight = 50}, box,
                      {300, 200});
    EXPECT_NEAR(scaleBar(flat, glm::dvec3(1)).length, 10, 1e-9);
    EXPECT_NEAR(scaleBar(flat, glm::dvec3(1)).width, 40, 1e-9);
    // The data's world is half as wide in x, and x is to the right.
    EXPECT_NEAR(scaleBar(flat, {2, 1, 7}).length, 5, 1e-9);
    EXPECT_NEAR(scaleBar(flat, {2, 1, 7}).width, 40, 1e-9);
    // A bar beside the target is as long as its two ends are apart in the picture.
    const Camera deep({.eye = glm::dvec3(50, -200, 50)}, box, {300, 200});
    const ScaleBar bar = scaleBar(deep, glm::dvec3(1));
    const auto x = [&](const glm::dvec3& point) {
        const glm::dvec4 ndc = deep.worldToNdc() * glm::dvec4(point, 1);
        return ndc.x / ndc.w * 300;
    };
    EXPECT_NEAR(x(deep.target() + glm::dvec3(bar.length, 0, 0)) - x(deep.target()), bar.width, 1e-9);
    EXPECT_LE(bar.width, 60);
    EXPECT_GT(bar.width, 60 / 2.5 - 1e-9);
}

TEST(Annotations, AxesOfWeatherAreEastNorthAndUp)
{
    const glm::dvec3 raised(1, 1, 30), equal(1);
    EXPECT_TRUE(isGeographic({0, 3600, "2020-01-01T00:00:00"}, "m", equal));
    EXPECT_TRUE(isGeographic({0, 3600}, "", raised));
    EXPECT_FALSE(isGeographic({0, 3600}, "m", equal));
    EXPECT_FALSE(isGeographic({0, 3600}, "", {30, 1, 1}));
    EXPECT_FALSE(isGeographic({0, 0.05}, "m", raised)); // a model in a tank
    EXPECT_FALSE(isGeographic({}, "", raised));
}

TEST(Annotations, TitlesTellUnits)
{
    EXPECT_EQ(scalarTitle("magnitude", "m/s"), "speed [m/s]");
    EXPECT_EQ(scalarTitle("magnitude", ""), "speed");
    EXPECT_EQ(scalarTitle("q", scalarUnit("q", "")), "Q criterion [1/s²]");
    EXPECT_EQ(scalarUnit("q", "1/h²"), "1/h²");
    EXPECT_EQ(scalarUnit("magnitude", ""), "");
    const auto axis = [](double largest, const char* unit) {
        const AxisUnit shown = axisUnit(largest, unit);
        return std::pair(shown.factor, shown.text);
    };
    EXPECT_EQ(axis(480e3, "m"), std::pair(1e3, std::string("km")));
    EXPECT_EQ(axis(480e3, ""), std::pair(1e3, std::string("10³")));
    EXPECT_EQ(axis(6e6, ""), std::pair(1e3, std::string("10³")));
    EXPECT_EQ(axis(6e7, "ft"), std::pair(1e6, std::string("10⁶ ft")));
    EXPECT_EQ(axis(5500, "m"), std::pair(1.0, std::string("m")));
    EXPECT_EQ(axis(0.17, "m"), std::pair(1e-3, std::string("mm")));
    EXPECT_EQ(axis(2e-4, "m"), std::pair(1e-6, std::string("µm")));
    EXPECT_EQ(axis(0.004, "m"), std::pair(1e-3, std::string("mm")));
    EXPECT_EQ(axis(0.004, ""), std::pair(1e-3, std::string("10⁻³")));
    EXPECT_EQ(axis(8e-9, "1/s²"), std::pair(1e-9, std::string("10⁻⁹ 1/s²")));
    EXPECT_EQ(axis(0.3, ""), std::pair(1.0, std::string()));
    EXPECT_EQ(axis(0, "m"), std::pair(1.0, std::string("m")));
}

TEST(Annotations, AFontThatLacksCharactersIsTold)
{
    EXPECT_EQ(annotationFont("Wake, 1/s² µ").missing, "");
    EXPECT_EQ(annotationFont("a\xff\xfe").missing, "");              // no characters
    EXPECT_EQ(annotationFont("A \U0010FFFD").missing, "\U0010FFFD"); // for private use: in no font
}

TEST(Annotations, TicksOfALogarithmicScaleArePowersOfTen)
{
    const auto texts = [](double low, double high) {
        std::string all;
        for (const Tick& tick : ticks({{low, high}, ValueScale::kLogarithmic}, 5))
            all += tick.text + " ";
        return all;
    };
    EXPECT_EQ(texts(0.02, 30), "0.1 1 10 ");
    EXPECT_EQ(texts(0.01, 100), "0.01 0.1 1 10 100 ");
    EXPECT_EQ(texts(1.5, 40), "2 5 10 20 ");
    EXPECT_EQ(texts(1e-10, 1e10), "1e-08 0.0001 1 1e+04 1e+08 ");
    EXPECT_EQ(texts(2, 6), "2 3 4 5 6 ");
}

class AnnotatedPicture : public testing::Test {
  protected:
    Image annotated(const AnnotationParams& params)
    {
        Image image = castRays(mVolume, mLook, mCamera, {});
        const std::vector<glm::vec4> before = image.pixels;
        annotate(image, params, {mVolume.corners(), glm::dvec3(1), "magnitude", "q", 7, {0.5}}, mLook, mCamera,
                 glm::dvec3(0));
        EXPECT_EQ(image.pixels, before);
        EXPECT_EQ(image.annotations.size(), before.size());
        return image;
    }
    /// The annotations' alpha at a point of the picture.
    static float inkAt(const Image& image, const glm::dvec2& at)
    {
        float most = 0; // of a line's width around it
        for (int y = int(at.y) - 1; y <= int(at.y) + 1; ++y) {
            for (int x = int(at.x) - 1; x <= int(at.x) + 1; ++x)
                most = std::max(most, image.annotations[std::size_t(y * image.size.x + x)].a);
        }
        return most;
    }
    [[nodiscard]] glm::dvec2 seenAt(const glm::dvec3& point) const
    {
        const glm::dvec4 ndc = mCamera.worldToNdc() * glm::dvec4(point, 1);
        return glm::dvec2(ndc) / ndc.w * glm::dvec2(mCamera.size());
    }

    openvdb::FloatGrid::Ptr mGrid = boxGrid("density", boxOf(20, 20, 20), [](const openvdb::Coord&) { return 1.0f; });
    TextureVolume mVolume{*mGrid, *mGrid};
    Look mLook = plainLook(0.9);
    Camera mCamera{{.projection = Projection::kOrthographic, .eye = glm::dvec3(-40, -60, 50), .viewHeight = 50},
                   mVolume.corners(),
                   {300, 200}};
};

TEST_F(AnnotatedPicture, NearEdgesAreInFrontAndFarEdgesBehind)
{
    const Image image = annotated({.box = true});
    // The corner at (−½, −½, 19½) is the nearest, (19½, 19½, −½) the farthest. Opaque voxels hide the edges to it.
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 near(-0.5, -0.5, 19.5), far(19.5, 19.5, -0.5);
        near[axis] = far[axis] = 9.5;
        EXPECT_GT(inkAt(image, seenAt(near)), 0.4f) << axis;
        EXPECT_LT(inkAt(image, seenAt(far)), 0.02f) << axis;
    }
    mLook = plainLook(1e-6);
    const Image clear = annotated({.box = true});
    EXPECT_GT(inkAt(clear, seenAt({9.5, 19.5, -0.5})), 0.4f);
}

TEST_F(AnnotatedPicture, ScalesHaveTheColoursOfTheTransferFunction)
{
    mLook.transfer = TransferFunction({.colors = {{0, {1, 0, 0}}, {1, {0, 0, 1}}},
                                       .opacity = {{0, 0}, {1, 0.5}},
                                       .range = {{0, 4}},
                                       .opacityRange = {{0, 9}}});
    const Image image = annotated({.colorBar = true});
    // Along a column in the scales: red at its foot, blue at its head; below it the scale of opacity.
    int red = 0, blue = 0, clear = 0, full = 0;
    for (int y = 0; y < 200; ++y) {
        const glm::vec4& pixel = image.annotations[std::size_t(y * 300 + 288)];
        red += pixel.r > 0.9f && pixel.b < 0.02f;
        blue += pixel.b > 0.9f && pixel.r < 0.02f;
        full += y > 100 && pixel.a > 0.9f;
        clear += y > 100 && pixel.a < 0.1f;
    }
    EXPECT_GT(red, 1);
    EXPECT_GT(blue, 1);
    EXPECT_GT(full, 4);
    EXPECT_GT(clear, 10);
}

TEST(AnnotatedBox, HasItsLabelsInThePictureAndTheColourBarBesideIt)
{
    const glm::ivec2 sizes[] = {{400, 400}, {640, 300}, {300, 480}};
    const glm::dvec3 shapes[] = {{1, 1, 1}, {480e3, 480e3, 5500}, {20, 20, 1}, {0.1, 0.1, 2}, {30, 1, 1}, {4, 3, 0.4}};
    for (const glm::dvec3& shape : shapes) {
        for (const glm::ivec2& size : sizes) {
            const AnnotationParams params{.box = true, .axes = true, .colorBar = true};
            Corners box;
            for (std::size_t i = 0; i < 8; ++i)
                box[i] = shape * glm::dvec3(double(i & 1), double(i >> 1 & 1), double(i >> 2));
            const Camera view({}, box, size, box);
            const Camera camera({}, box, size, withRoom({box.begin(), box.end()}, params, view));
            Image image;
            image.size = size;
            image.pixels.resize(std::size_t(size.x) * std::size_t(size.y));
            annotate(image, params, {box, glm::dvec3(1), "magnitude", "magnitude", 1}, plainLook(0.5), camera,
                     glm::dvec3(0));
            for (int y = 0; y < size.y; ++y) {
                for (int x = 0; x < size.x; ++x) {
                    if (x > 0 && y > 0 && x < size.x - 1 && y < size.y - 1) continue;
                    EXPECT_EQ(image.annotations[std::size_t(y * size.x + x)].a, 0) << x << " " << y;
                }
            }
            for (const glm::dvec3& corner : box) {
                const glm::dvec4 ndc = camera.worldToNdc() * glm::dvec4(corner, 1);
                EXPECT_LT(ndc.x / ndc.w * size.x, size.x - 5.5 * size.y / 42.0) << shape.x << " " << size.x;
            }
        }
    }
}

TEST_F(AnnotatedPicture, EveryAnnotationDrawsAndIsInThePicture)
{
    const std::string none = displayBytes(annotated({}), {});
    for (const char* text : {"box", "axes", "colorbar", "time", "scalebar", "triad", "title=T"})
        EXPECT_NE(displayBytes(annotated(parseAnnotations(text)), {}), none) << text;
}

} // namespace
} // namespace vdblic
