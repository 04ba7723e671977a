#include "vdblic/render/annotations.h"

#include "cast/test_scene.h"
#include "vdblic/core/errors.h"
#include "vdblic/image/image_file.h"
#include "vdblic/render/annotated_box.h"

#include <gtest/gtest.h>

#include <cstddef>

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
        annotate(image, params, {mVolume.corners(), glm::dvec3(1), "magnitude", "q", 7, 0.5}, mLook, mCamera,
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

TEST_F(AnnotatedPicture, EveryAnnotationDrawsAndIsInThePicture)
{
    const std::string none = displayBytes(annotated({}), {});
    for (const char* text : {"box", "axes", "colorbar", "time", "title=T"})
        EXPECT_NE(displayBytes(annotated(parseAnnotations(text)), {}), none) << text;
}

} // namespace
} // namespace vdblic
