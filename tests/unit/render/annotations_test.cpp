#include "vdblic/render/annotations.h"

#include "cast/test_scene.h"
#include "vdblic/core/errors.h"
#include "vdblic/image/image_file.h"
#include "vdblic/render/annotated_box.h"
#include "vdblic/render/annotation_font.h"
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
    for (const char* text : {"box", "axes,time", "box,axes,colorbar,time,title=A, b = c"})
        EXPECT_EQ(annotationText(parseAnnotations(text)), text);
    for (const char* bad : {"", "box,", "frame", "title", "title=", "box time"})
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
    EXPECT_EQ(text(10800, 10800), "3 h 00 min");
    EXPECT_EQ(text(0, 3600), "0 min");
    EXPECT_EQ(text(3979, 568.421), "1 h 06 min 19 s");
    EXPECT_EQ(text(266400, 3600), "3 d 02 h 00 min");
    EXPECT_EQ(text(0.05, 0.05), "0.05 s");
    EXPECT_EQ(text(1, 0.05), "1.00 s");
    EXPECT_EQ(text(1.0 / 24, 1.0 / 24), "0.042 s");
    EXPECT_EQ(text(-2.5, 0.5), "-2.5 s");
    EXPECT_EQ(text(200, 0.5), "3 min 20.0 s");
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

TEST(Annotations, TitlesTellUnits)
{
    EXPECT_EQ(scalarTitle("magnitude", "m/s"), "speed [m/s]");
    EXPECT_EQ(scalarTitle("magnitude", ""), "speed");
    EXPECT_EQ(scalarTitle("q", ""), "q [1/s²]");
    const auto axis = [](double largest, const char* unit) {
        const AxisUnit shown = axisUnit(largest, unit);
        return std::pair(shown.factor, shown.text);
    };
    EXPECT_EQ(axis(480e3, "m"), std::pair(1e3, std::string("km")));
    EXPECT_EQ(axis(480e3, ""), std::pair(1e3, std::string("10³")));
    EXPECT_EQ(axis(6e6, ""), std::pair(1e3, std::string("10³")));
    EXPECT_EQ(axis(6e7, "ft"), std::pair(1e6, std::string("10⁶ ft")));
    EXPECT_EQ(axis(5500, "m"), std::pair(1.0, std::string("m")));
    EXPECT_EQ(axis(0.004, "m"), std::pair(1e-3, std::string("mm")));
    EXPECT_EQ(axis(0.004, ""), std::pair(1e-3, std::string("10⁻³")));
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
    for (const char* text : {"box", "axes", "colorbar", "time", "title=T"})
        EXPECT_NE(displayBytes(annotated(parseAnnotations(text)), {}), none) << text;
}

} // namespace
} // namespace vdblic
