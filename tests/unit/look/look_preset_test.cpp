#include "vdblic/look/look_preset.h"

#include "cast/test_scene.h"
#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/look/transfer_file.h"

#include <gtest/gtest.h>

#include <fstream>

namespace vdblic {
namespace {

TEST(LookPreset, EveryNameMakesALook)
{
    const auto grid = boxGrid("density", boxOf(16, 16, 16), scattered);
    const TextureVolume volume(*grid, *grid);
    for (const std::string& name : lookPresetNames()) {
        const LookPreset preset = lookPreset(name);
        EXPECT_NO_THROW(preset.look.validate()) << name;
        EXPECT_TRUE(chooseLook(preset.look, volume).contributes(volume.leafRange(0))) << name;
    }
    EXPECT_THROW((void)lookPreset("sepia"), ParameterError);
}

TEST(TransferFile, SetsWhatItHoldsAndKeepsTheRest)
{
    const TemporaryFolder folder;
    const auto write = [&](const std::string& text) {
        std::ofstream(folder.path() / "t.json") << text;
        return folder.path() / "t.json";
    };
    TransferParams params{.colorMap = "gray", .opacity = {{0, 0.5}}};
    readTransferFile(write(R"({"range": [1, 4.5], "colors": [[0, 1, 0, 0], [1, 0, 0, 1]]})"), params);
    EXPECT_EQ(params.range, (std::array{1.0, 4.5}));
    EXPECT_EQ(opacityText(params.opacity), "0:0.5");
    const TransferFunction transfer(params);
    EXPECT_EQ(transfer.displayColor(0.25), glm::dvec3(0.75, 0, 0.25));
    EXPECT_EQ(transfer.colorMapName(), "points");
    readTransferFile(write(R"({"opacity_range": [-2, 8], "unit": "m/s", "opacity_unit": "1/s"})"), params);
    EXPECT_EQ(params.opacityRange, (std::array{-2.0, 8.0}));
    EXPECT_EQ(params.unit + params.opacityUnit, "m/s1/s");
    EXPECT_EQ(TransferFunction(params).range(), (std::array{1.0, 4.5}));
    EXPECT_THROW(readTransferFile(write(R"({"opacity_range": [2, 1]})"), params), InputError);
    params.opacityRange.reset();
    readTransferFile(write(R"({"colormap": "viridis", "opacity": [[0, 0], [0.5, 0.25]]})"), params);
    EXPECT_EQ(params.colorMap, "viridis");
    EXPECT_TRUE(params.colors.empty());
    EXPECT_EQ(opacityText(params.opacity), "0:0,0.5:0.25");
    for (const char* bad :
         {"", "[]", R"({"range": 3})", R"({"range": [2, 1]})", R"({"opacity": [[0, 2]]})", R"({"colour": 1})",
          R"({"unit": 1})", R"({"colors": [[0, 1, 1]]})", R"({"colors": [[0, 1, 1, 7]]})", R"({"colormap": 5})",
          R"({"opacity": []})", R"({"colormap": "gray", "colors": [[0, 0, 0, 0]]})"}) {
        try {
            readTransferFile(write(bad), params);
            ADD_FAILURE() << bad;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("t.json"), std::string::npos) << error.what();
        }
    }
    EXPECT_THROW(readTransferFile(folder.path() / "none.json", params), InputError);
}

} // namespace
} // namespace vdblic
