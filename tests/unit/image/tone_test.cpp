
#include "vdblic/image/color_map.h"
#include "vdblic/image/image_file.h"

#include <glm/common.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

namespace vdblic {
namespace {

float mostOf(const glm::vec3& light)
{
    return std::max({light.r, light.g, light.b});
}

TEST(ToneCurve, KeepsColoursUpToItsKneeAndHuesAbove)
{
    const glm::vec3 hue(1, 0.5f, 0.25f);
    float before = 0;
    for (float light = 0.05f; light < 64; light *= 1.1f) {
        const glm::vec3 shown = toneMapped(hue * light, kToneKnee);
        EXPECT_GT(mostOf(shown), before) << light;
        EXPECT_LT(mostOf(shown), 1);
        before = mostOf(shown);
        if (light <= kToneKnee) {
            EXPECT_EQ(shown, hue * light);
        } else if (light < 2) {
            // One stop and more above the knee colours are themselves to a hundredth or two of white.
            EXPECT_NEAR(shown.g / shown.r, 0.5, 0.08) << light;
            EXPECT_NEAR(shown.b / shown.r, 0.25, 0.12) << light;
        }
    }
    // What is very bright is white.
    EXPECT_GT(toneMapped(hue * 1000.0f, kToneKnee).b, 0.95f);
    // The curve has no corner at the knee.
    const float step = 1e-3f;
    EXPECT_NEAR((mostOf(toneMapped(glm::vec3(kToneKnee + step), kToneKnee)) - kToneKnee) / step, 1, 0.02);
}

TEST(ToneCurve, BackgroundsAndAnnotationsAreAsAsked)
{
    for (const glm::dvec3& color : {glm::dvec3(0.04, 0.05, 0.07), glm::dvec3(0.965, 0.95, 0.915), glm::dvec3(1)}) {
        const glm::vec3 light(linearFromDisplay(color));
        // Nothing, the background's own light, something ten times as bright, and an annotation over that.
        Image image{{4, 1}, {{0, 0, 0, 0}, {light, 1}, {light * 10.0f, 1}, {4, 4, 4, 1}}};
        image.annotations = {glm::vec4(0), glm::vec4(0), glm::vec4(0), {1, 0, 0, 1}};
        const std::string bytes = displayBytes(image, {.color = color});
        for (std::size_t i = 0; i < 6; ++i)
            EXPECT_NEAR(static_cast<unsigned char>(bytes[i]), color[int(i % 3)] * 255, 0.51) << i;
        EXPECT_GE(static_cast<unsigned char>(bytes[6]), static_cast<unsigned char>(bytes[0]));
        EXPECT_EQ(bytes.substr(9), std::string("\xff\0\0", 3));
    }
}

TEST(Exposure, DoublesLightByTheStopAndLeavesTheRest)
{
    Image image{{2, 1}, {{0.25f, 0.5f, 1, 0.5f}, {0, 0, 0, 0}}};
    image.layers.resize(2);
    image.layers[0].depth = 3;
    image.annotations = {{0.5f, 0.5f, 0.5f, 0.5f}, glm::vec4(0)};
    const Image brighter = exposed(image, 2);
    EXPECT_EQ(brighter.pixels, (std::vector<glm::vec4>{{1, 2, 4, 0.5f}, {0, 0, 0, 0}}));
    EXPECT_EQ(brighter.layers[0].depth, 3);
    EXPECT_EQ(brighter.annotations, image.annotations);
    EXPECT_EQ(exposed(image, 0).pixels, image.pixels);
    EXPECT_FLOAT_EQ(exposed(image, -1.5).pixels[0].b, float(std::exp2(-1.5)));
}

} // namespace
} // namespace vdblic
