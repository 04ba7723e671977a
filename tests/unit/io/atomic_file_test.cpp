#include "vdblic/io/atomic_file.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <unistd.h>

namespace vdblic {
namespace {

namespace fs = std::filesystem;

std::string textOf(const fs::path& path)
{
    std::ifstream stream(path);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(AtomicFile, AppearsOnlyWhenCommitted)
{
    const TemporaryFolder folder;
    const fs::path final = folder / "out.vdb";
    {
        AtomicFile file(final);
        std::ofstream(file.temporary()) << "new";
        EXPECT_FALSE(fs::exists(final));
        EXPECT_EQ(file.temporary().parent_path(), folder.path());
        file.commit();
        EXPECT_FALSE(fs::exists(file.temporary()));
        EXPECT_EQ(textOf(final), "new");
    }
    EXPECT_EQ(textOf(final), "new");
}

TEST(AtomicFile, WithoutCommitLeavesAllAsItWas)
{
    const TemporaryFolder folder;
    const fs::path final = folder / "out.vdb";
    {
        AtomicFile file(final);
        std::ofstream(file.temporary()) << "half";
    }
    EXPECT_TRUE(folder.empty());
    folder.add("out.vdb", "old");
    {
        AtomicFile file(final);
        std::ofstream(file.temporary()) << "half";
        EXPECT_EQ(textOf(final), "old");
    }
    EXPECT_EQ(textOf(final), "old");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(AtomicFile, ReplacesAnOlderFileAndWhatAKilledRunLeft)
{
    const TemporaryFolder folder;
    const fs::path final = folder.add("out.vdb", "old");
    folder.add(AtomicFile(final).temporary().filename().string(), "left behind, and longer");
    AtomicFile file(final);
    std::ofstream(file.temporary(), std::ios::app) << "new";
    file.commit();
    EXPECT_EQ(textOf(final), "new");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(AtomicFile, WritesToTheCurrentFolderToo)
{
    const TemporaryFolder folder;
    const fs::path before = fs::current_path();
    fs::current_path(folder.path());
    {
        AtomicFile file("out.vdb");
        std::ofstream(file.temporary()) << "new";
        file.commit();
    }
    fs::current_path(before);
    EXPECT_EQ(textOf(folder / "out.vdb"), "new");
}

TEST(AtomicFile, RefusesFoldersThatAreMissingOrInTheWay)
{
    const TemporaryFolder folder;
    const fs::path file = folder.add("file");
    EXPECT_THROW(AtomicFile(folder / "none/out.vdb"), OutputError);
    EXPECT_THROW(AtomicFile(file / "out.vdb"), OutputError);
    EXPECT_THROW(AtomicFile{folder.path()}, OutputError);
    EXPECT_THROW(AtomicFile(fs::path("/proc/out.vdb")), OutputError);
}

TEST(AtomicFile, RefusesAReadOnlyFolder)
{
    if (::geteuid() == 0) GTEST_SKIP() << "root may write to any folder";
    const TemporaryFolder folder;
    fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec);
    EXPECT_THROW(AtomicFile(folder / "out.vdb"), OutputError);
    fs::permissions(folder.path(), fs::perms::owner_all);
    EXPECT_TRUE(folder.empty());
}

TEST(AtomicFile, SaysWhenItCannotBeRenamed)
{
    const TemporaryFolder folder;
    AtomicFile file(folder / "out.vdb");
    fs::create_directory(folder / "out.vdb"); // meanwhile
    EXPECT_THROW(file.commit(), OutputError);
    EXPECT_TRUE(fs::is_directory(folder / "out.vdb"));
}

} // namespace
} // namespace vdblic
