#include "vdblic/run/checkpoint.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/checksum.h"
#include "vdblic/run/advect_plan.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace vdblic {
namespace {

const Checkpoint kCheckpoint{{7, 0.1, 1.0 / 3, 2, 0.3}, {"frame 1, size 5", "frame 3, size 6"}, {}};

/// The message with which reading is refused.
template<typename ErrorT>
std::string refusal(const std::filesystem::path& path, const ParameterTexts& parameters)
{
    try {
        (void)readCheckpoint(path, parameters);
    } catch (const ErrorT& error) {
        return error.what();
    }
    return "nothing";
}

void expectPart(const std::string& text, const std::string& part)
{
    EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
}

TEST(Checkpoint, GivesBackWhatItWasGiven)
{
    const TemporaryFolder folder;
    writeCheckpoint(folder / "c.vdb", kCheckpoint, {{"life_span", "4"}, {"mask", ""}});
    const Checkpoint read = readCheckpoint(folder / "c.vdb", {{"life_span", "4"}, {"mask", ""}});
    EXPECT_EQ(read.position.steps, kCheckpoint.position.steps);
    EXPECT_EQ(read.position.interval, kCheckpoint.position.interval);
    EXPECT_EQ(read.position.time, kCheckpoint.position.time);
    EXPECT_EQ(read.position.frameSpacing, kCheckpoint.position.frameSpacing);
    EXPECT_EQ(read.position.motion, kCheckpoint.position.motion);
    EXPECT_EQ(read.inputs, kCheckpoint.inputs);
}

TEST(Checkpoint, HoldsEveryParameterOfARun)
{
    const TemporaryFolder folder;
    AdvectParams params;
    params.flow.frameSpacing = 0.5;
    params.derived = {"vorticity", "q"};
    params.flow.domain.box = {0, 1, 2, 3, 4, 5};
    const ParameterTexts texts = parameterTexts(resolve(params));
    writeCheckpoint(folder / "c.vdb", kCheckpoint, texts);
    EXPECT_EQ(readCheckpoint(folder / "c.vdb", texts).position.frameSpacing, kCheckpoint.position.frameSpacing);
    const openvdb::MetaMap metadata = readVdb(folder / "c.vdb").metadata;
    EXPECT_EQ(metadata.metaValue<std::string>("life_span"), "4");
    EXPECT_EQ(metadata.metaValue<std::string>("frame_spacing"), "0.5");
    EXPECT_EQ(metadata.metaValue<std::string>("derived"), "vorticity,q");
    EXPECT_EQ(metadata.metaValue<std::string>("box"), "0 1 2 3 4 5");
    for (const auto& [key, value] : texts)
        EXPECT_EQ(metadata.metaValue<std::string>(key), value) << key;
}

TEST(Checkpoint, NamesTheParameterThatDiffers)
{
    const TemporaryFolder folder;
    const auto path = folder / "c.vdb";
    writeCheckpoint(path, kCheckpoint, {{"life_span", "4"}, {"mask", ""}});
    expectPart(refusal<ParameterError>(path, {{"life_span", "8"}, {"mask", ""}}),
               "the run that was interrupted had `life_span` 4, this one has `life_span` 8");
    expectPart(refusal<ParameterError>(path, {{"life_span", "4"}, {"mask", "m.vdb"}}),
               "had no `mask`, this one has `mask` m.vdb");
}

TEST(Checkpoint, OtherFilesAreRefused)
{
    const TemporaryFolder folder;
    const auto path = folder / "c.vdb";
    writeVdb(path, {}, {});
    expectPart(refusal<InputError>(path, {}), "is no checkpoint of vdblic_advect");
    folder.add("c.vdb", "something else");
    expectPart(refusal<InputError>(path, {}), "delete the checkpoint to start from the beginning");
}

/// Replace a text in a file by one of the same length, and update the checksums.
void edit(const std::filesystem::path& path, const std::string& from, const std::string& to)
{
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    ASSERT_NE(bytes.find(from), std::string::npos);
    file.seekp(std::streamoff(bytes.find(from)));
    file << to << std::flush;
    const VdbLayout layout = readLayout(file, bytes.size());
    const std::string checksums = computeChecksums(file, layout);
    file.seekp(std::streamoff(layout.checksum.offset));
    file << checksums;
    file.seekp(std::streamoff(VdbLayout::kIdentityOffset));
    file << identityOf(checksums);
}

TEST(Checkpoint, OfAnotherVersionIsRefused)
{
    const TemporaryFolder folder;
    const auto path = folder / "c.vdb";
    writeCheckpoint(path, kCheckpoint, {});
    edit(path, "VDBLIC 1", "VDBLIC 9");
    expectPart(refusal<InputError>(path, {}), "was written by VDBLIC 9");
}

TEST(Checkpoint, ThatSomebodyEditedIsRefused)
{
    const TemporaryFolder folder;
    const auto path = folder / "c.vdb";
    writeCheckpoint(path, kCheckpoint, {{"life_span", "4"}});
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(std::streamoff(VdbLayout::kIdentityOffset)); // as another program's, which has no checksums
    file << "00000000" << std::flush;
    expectPart(refusal<InputError>(path, {}), "its checksums are gone");
}

} // namespace
} // namespace vdblic
