#include "vdblic/io/file_stamp.h"

#include "temporary_folder.h"
#include "vdblic/io/vdb_file.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <chrono>

namespace vdblic {
namespace {

TEST(FileStamp, TellsSizeTimeAndIdentity)
{
    const TemporaryFolder folder;
    const auto path = folder.add("a.txt", "four");
    const std::string before = fileStamp(path);
    EXPECT_TRUE(before.starts_with("size 4, modified ")) << before;
    EXPECT_TRUE(before.ends_with(" UTC, identity none")) << before;
    EXPECT_EQ(fileStamp(path), before);
    const auto time = std::filesystem::last_write_time(path);
    std::filesystem::last_write_time(path, time + std::chrono::nanoseconds(1));
    EXPECT_TRUE(stampDifference(before, fileStamp(path)).starts_with("then modified"));
    folder.add("a.txt", "eleven");
    std::filesystem::last_write_time(path, time);
    EXPECT_EQ(stampDifference(before, fileStamp(path)), "then size 4, now size 6");
    EXPECT_EQ(fileStamp(folder / "b.txt"), "missing");
    EXPECT_EQ(stampDifference(before, "missing"), "then " + before + "; now missing");
}

TEST(FileStamp, SeesAnotherVoxelInAFileOfTheSameSizeAndTime)
{
    const TemporaryFolder folder;
    const auto path = folder / "a.vdb";
    std::string stamps[2];
    for (const int value : {0, 1}) {
        const auto grid = openvdb::Int32Grid::create();
        grid->tree().setValue({1, 2, 3}, value + 10);
        writeVdb(path, {grid}, {});
        std::filesystem::last_write_time(path, std::filesystem::file_time_type{});
        stamps[value] = fileStamp(path);
    }
    EXPECT_TRUE(stampDifference(stamps[0], stamps[1]).starts_with("then identity "))
        << stampDifference(stamps[0], stamps[1]);
}

} // namespace
} // namespace vdblic
