#include "vdblic/compare/compare.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "temporary_folder.h"

#include <fstream>
#include <string>

namespace vdblic {
namespace {

class CompareFiles : public testing::Test {
  protected:
    [[nodiscard]] std::string in(const std::string& name) const { return (mFolder / name).string(); }

    static openvdb::FloatGrid::Ptr grid(const std::string& name, float value)
    {
        auto result = openvdb::FloatGrid::create();
        result->setName(name);
        result->tree().setValue(openvdb::Coord(1, 2, 3), value);
        return result;
    }
    void write(const std::string& name, const openvdb::GridCPtrVec& grids) const { writeVdb(in(name), grids, {}); }

    TemporaryFolder mFolder;
};

TEST_F(CompareFiles, OrderOfGridsDoesNotMatterButOrderOfEqualNamesDoes)
{
    write("a.vdb", {grid("x", 1), grid("y", 2), grid("y", 3)});
    write("b.vdb", {grid("y", 2), grid("y", 3), grid("x", 1)});
    write("c.vdb", {grid("y", 3), grid("y", 2), grid("x", 1)});
    EXPECT_EQ(compareFiles(in("a.vdb"), in("b.vdb")).verdict(), Verdict::kSame);
    const FileDifference swapped = compareFiles(in("a.vdb"), in("c.vdb"));
    ASSERT_EQ(swapped.grids.size(), 3u);
    EXPECT_EQ(swapped.grids[0].verdict(), Verdict::kSame);
    EXPECT_EQ(swapped.grids[2].name, "y");
    EXPECT_EQ(swapped.grids[2].occurrence, 1);
    EXPECT_EQ(swapped.grids[2].verdict(), Verdict::kDiffers);
}

TEST_F(CompareFiles, AGridOnOneSideOnlyIsADifference)
{
    write("a.vdb", {grid("x", 1), grid("y", 2)});
    write("b.vdb", {grid("x", 1), grid("z", 2)});
    const FileDifference result = compareFiles(in("a.vdb"), in("b.vdb"));
    ASSERT_EQ(result.grids.size(), 3u);
    EXPECT_EQ(result.grids[1].name, "y");
    EXPECT_EQ(result.grids[1].typeA, "float");
    EXPECT_TRUE(result.grids[1].isMissing());
    EXPECT_EQ(result.grids[2].name, "z");
    EXPECT_EQ(result.grids[2].typeA, "");
    EXPECT_EQ(result.verdict(), Verdict::kDiffers);
}

TEST_F(CompareFiles, FileMetadataIsComparedAndHalfPrecisionIsNoDifferenceInItself)
{
    auto half = grid("x", 0.5f); // exact in half precision
    half->setSaveFloatAsHalf(true);
    openvdb::MetaMap metadata;
    metadata.insertMeta("life", openvdb::Int32Metadata(4));
    writeVdb(in("a.vdb"), {half}, metadata);
    write("b.vdb", {grid("x", 0.5f)});
    const FileDifference result = compareFiles(in("a.vdb"), in("b.vdb"));
    EXPECT_EQ(result.grids[0].verdict(), Verdict::kSame);
    ASSERT_EQ(result.metadata.size(), 1u);
    EXPECT_EQ(result.metadata[0].key, "life");
    EXPECT_EQ(result.metadata[0].a, "4");
}

TEST_F(CompareFiles, SequencesAreMatchedByFrameNumber)
{
    for (int frame : {1, 2, 3})
        write(fmt::format("a.{:04d}.vdb", frame), {grid("x", float(frame))});
    for (int frame : {2, 3, 4})
        write(fmt::format("b{}.vdb", frame), {grid("x", frame == 3 ? 0.f : float(frame))});
    Reporter silent;
    CompareSequencesParams params{
        .a = in("a.%04d.vdb"), .b = in("b#.vdb"), .frames = {}, .output = {}, .json = {}, .compare = {}};
    const SequenceDifference all = compareSequences(params, silent);
    ASSERT_EQ(all.frames.size(), 4u);
    EXPECT_FALSE(all.frames[0].inB);
    EXPECT_EQ(all.frames[0].verdict(), Verdict::kDiffers);
    EXPECT_EQ(all.frames[1].verdict(), Verdict::kSame);
    EXPECT_EQ(all.frames[2].verdict(), Verdict::kDiffers);
    EXPECT_FALSE(all.frames[3].inA);
    EXPECT_EQ(all.verdict(), Verdict::kDiffers);

    params.frames = "2";
    EXPECT_EQ(compareSequences(params, silent).verdict(), Verdict::kSame);
    params.frames = "1-2";
    EXPECT_EQ(compareSequences(params, silent).verdict(), Verdict::kDiffers);
    params.frames = "2-9";
    EXPECT_THROW((void)compareSequences(params, silent), InputError);
    params.frames.clear();
    params.b = in("none.#.vdb");
    EXPECT_THROW((void)compareSequences(params, silent), InputError);
    params.b = in("b2.vdb");
    EXPECT_THROW((void)compareSequences(params, silent), ParameterError);
}

TEST_F(CompareFiles, AnInputIsNotOverwritten)
{
    write("a.vdb", {grid("x", 1)});
    write("b.vdb", {grid("x", 2)});
    Reporter silent;
    for (const bool json : {false, true}) {
        CompareSequencesParams params{
            .a = in("a.vdb"), .b = in("b.vdb"), .frames = {}, .output = {}, .json = {}, .compare = {}};
        (json ? params.json : params.output) = in("b.vdb");
        EXPECT_THROW((void)compareSequences(params, silent), ParameterError);
    }
    EXPECT_EQ(readVdb(in("b.vdb")).grids.size(), 1u);
}

TEST_F(CompareFiles, ADamagedFileIsAnInputErrorThatNamesIt)
{
    write("a.vdb", {grid("x", 1)});
    std::ofstream(in("b.vdb")) << "no volume";
    try {
        (void)compareFiles(in("a.vdb"), in("b.vdb"));
        FAIL() << "read";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("b.vdb"), std::string::npos);
    }
}

} // namespace
} // namespace vdblic
