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
        EXPECT_TRUE(folder.empty()); // a process killed here leaves nothing behind
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
    for (const auto kind : {AtomicFile::Temporary::kUnnamedIfPossible, AtomicFile::Temporary::kNamed}) {
        folder.add(".out.vdb.part", "left behind, and longer");
        AtomicFile file(final, kind);
        std::ofstream(file.temporary(), std::ios::app) << "new";
        file.commit();
        EXPECT_EQ(textOf(final), "new");
        EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
    }
}

TEST(AtomicFile, HasAHiddenNameWhereItMustHaveOne)
{
    const TemporaryFolder folder;
    {
        AtomicFile file(folder / "out.vdb", AtomicFile::Temporary::kNamed);
        EXPECT_EQ(file.temporary(), folder / ".out.vdb.part");
        EXPECT_TRUE(fs::exists(file.temporary()));
    }
    EXPECT_TRUE(folder.empty());
}

TEST(AtomicFile, OfTwoAtOnceTheLastStaysWhole)
{
    const TemporaryFolder folder;
    AtomicFile first(folder / "out.vdb"), second(folder / "out.vdb");
    std::ofstream(first.temporary()) << "first";
    std::ofstream(second.temporary()) << "second";
    first.commit();
    second.commit();
    EXPECT_EQ(textOf(folder / "out.vdb"), "second");
}

TEST(CheckNotInput, KnowsAFileByAnyName)
{
    const TemporaryFolder folder;
    const fs::path file = folder.add("a.vdb");
    fs::create_symlink(file, folder / "link.vdb");
    EXPECT_THROW(checkNotInput(folder / "link.vdb", file), ParameterError);
    EXPECT_THROW(checkNotInput(folder.path() / "." / "a.vdb", file), ParameterError);
    EXPECT_NO_THROW(checkNotInput(folder / "b.vdb", file));
    EXPECT_NO_THROW(checkNotInput(folder / "b.vdb", folder / "none.vdb"));
}

TEST(CheckDistinct, KnowsNamesThatAreNotThereYet)
{
    const TemporaryFolder folder;
    EXPECT_THROW(checkDistinct(folder / "a.vdb", folder.path() / "." / "a.vdb"), ParameterError);
    EXPECT_THROW(checkDistinct("a.vdb", fs::current_path() / "none" / ".." / "a.vdb"), ParameterError);
    EXPECT_NO_THROW(checkDistinct(folder / "a.vdb", folder / "b.vdb"));
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
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2); // the hidden name goes with the object
}

} // namespace
} // namespace vdblic
