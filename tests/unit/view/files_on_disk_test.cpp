#include "view/files_on_disk.h"

#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace vdblic::view {
namespace {

std::vector<std::int64_t> framesOf(const std::vector<FileSeen>& files)
{
    std::vector<std::int64_t> frames;
    frames.reserve(files.size());
    for (const FileSeen& file : files)
        frames.push_back(file.frame);
    return frames;
}

TEST(FilesOnDisk, AreThoseSelectedThatAreThere)
{
    const TemporaryFolder folder;
    for (const char* name : {"lic.10.vdb", "lic.2.vdb", "lic.3.vdb", "lic.5.vdb", "other.4.vdb"})
        folder.add(name);
    const std::string pattern = folder / "lic.%d.vdb";
    EXPECT_EQ(framesOf(filesOnDisk({.pattern = pattern, .frames = {}})), (std::vector<std::int64_t>{2, 3, 5, 10}));
    EXPECT_EQ(framesOf(filesOnDisk({.pattern = pattern, .frames = "2-5"})), (std::vector<std::int64_t>{2, 3, 5}));

    const std::vector<FileSeen> before = filesOnDisk({.pattern = pattern, .frames = "2"});
    EXPECT_EQ(filesOnDisk({.pattern = pattern, .frames = "2"}), before);
    folder.add("lic.2.vdb", "texture");
    EXPECT_NE(filesOnDisk({.pattern = pattern, .frames = "2"}), before);
}

TEST(FilesOnDisk, MayBeOne)
{
    const TemporaryFolder folder;
    const std::string path = folder / "lic.0007.vdb";
    EXPECT_TRUE(filesOnDisk({.pattern = path, .frames = {}}).empty());
    folder.add("lic.0007.vdb");
    EXPECT_EQ(framesOf(filesOnDisk({.pattern = path, .frames = {}})), (std::vector<std::int64_t>{7}));
}

TEST(FilesOnDisk, HaveCopiesThatAreNoOlder)
{
    const TemporaryFolder folder;
    const SequenceParams input{.pattern = folder / "lic.%d.vdb", .frames = {}};
    const FrameFile frame{1, folder / "lic.1.vdb"};
    for (const char* name : {"lic.1.vdb", "lic.level1.1.vdb", "lic.level2.1.vdb", "lic.level4.1.vdb"})
        folder.add(name);
    const std::vector<FrameFile> copies = coarserCopies(input, frame); // the third level is missing
    ASSERT_EQ(copies.size(), 2);
    EXPECT_EQ(copies[1].frame, 1);
    EXPECT_EQ(copies[1].path, folder / "lic.level2.1.vdb");

    const auto earlier = std::filesystem::last_write_time(frame.path) - std::chrono::hours(1);
    std::filesystem::last_write_time(folder / "lic.level1.1.vdb", earlier);
    EXPECT_TRUE(coarserCopies(input, frame).empty());
}

} // namespace
} // namespace vdblic::view
