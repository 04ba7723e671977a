#include "vdblic/lic/checkpoint.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/checksum.h"

#include <gtest/gtest.h>

namespace vdblic {
namespace {

const Checkpoint kCheckpoint{7, 0.1, 1.0 / 3, 2, {"frame 1, size 5", "frame 3, size 6"}, {}};

/// What reading says against it.
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

void expectContains(const std::string& text, const std::string& part)
{
    EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
}

TEST(Checkpoint, GivesBackWhatItWasGiven)
{
    const TemporaryFolder folder;
    writeCheckpoint(folder / "c.vdb", kCheckpoint, {{"--life", "4"}, {"--mask", ""}});
    const Checkpoint read = readCheckpoint(folder / "c.vdb", {{"--life", "4"}, {"--mask", ""}});
    EXPECT_EQ(read.steps, kCheckpoint.steps);
    EXPECT_EQ(read.interval, kCheckpoint.interval);
    EXPECT_EQ(read.time, kCheckpoint.time);
    EXPECT_EQ(read.frameSpacing, kCheckpoint.frameSpacing);
    EXPECT_EQ(read.inputs, kCheckpoint.inputs);
}

TEST(Checkpoint, NamesTheParameterThatDiffers)
{
    const TemporaryFolder folder;
    const auto path = folder / "c.vdb";
    writeCheckpoint(path, kCheckpoint, {{"--life", "4"}, {"--mask", ""}});
    expectContains(refusal<ParameterError>(path, {{"--life", "8"}, {"--mask", ""}}),
                   "the run that was interrupted had --life 4, this one has --life 8");
    expectContains(refusal<ParameterError>(path, {{"--life", "4"}, {"--mask", "m.vdb"}}),
                   "had no --mask, this one has --mask m.vdb");
}

TEST(Checkpoint, OtherFilesAreRefused)
{
    const TemporaryFolder folder;
    const auto path = folder / "c.vdb";
    writeVdb(path, {}, {});
    expectContains(refusal<InputError>(path, {}), "is no checkpoint of vdblic_advect");
    folder.add("c.vdb", "something else");
    expectContains(refusal<InputError>(path, {}), "delete the checkpoint to start from the beginning");
}

/// Replace a text in a file by one as long, and see to its checksums.
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
    edit(path, "VDBLIC 0", "VDBLIC 9");
    expectContains(refusal<InputError>(path, {}), "was written by VDBLIC 9");
}

TEST(Checkpoint, ThatSomebodyEditedIsRefused)
{
    const TemporaryFolder folder;
    const auto path = folder / "c.vdb";
    writeCheckpoint(path, kCheckpoint, {{"--life", "4"}});
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(std::streamoff(VdbLayout::kIdentityOffset)); // as another program's, which has no checksums
    file << "00000000" << std::flush;
    expectContains(refusal<InputError>(path, {}), "its checksums are gone");
}

TEST(CheckpointSchedule, CountsSteps)
{
    CheckpointSchedule every3(3), none(0), byTime(std::nullopt);
    EXPECT_TRUE(every3.enabled());
    EXPECT_FALSE(none.enabled());
    EXPECT_TRUE(byTime.enabled());
    for (int i = 1; i < 10; ++i) {
        for (CheckpointSchedule* schedule : {&every3, &none, &byTime})
            schedule->stepDone();
        EXPECT_EQ(every3.isDue(), i % 3 == 0);
        EXPECT_FALSE(none.isDue());
        EXPECT_FALSE(byTime.isDue()); // not before half a minute
        if (every3.isDue()) every3.wrote({});
    }
}

} // namespace
} // namespace vdblic
