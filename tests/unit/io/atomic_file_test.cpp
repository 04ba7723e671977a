#include "vdblic/io/atomic_file.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"

#include <gtest/gtest.h>

#include <array>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

namespace vdblic {
namespace {

namespace fs = std::filesystem;

std::string textOf(const fs::path& path)
{
    std::ifstream stream(path);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::size_t fileCount(const TemporaryFolder& folder)
{
    return std::size_t(std::distance(fs::directory_iterator(folder.path()), {}));
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
    EXPECT_EQ(fileCount(folder), 1u);
}

constexpr auto kNamed = AtomicFile::Temporary::kNamed;

/// Another process that writes an output to a named temporary file until the test lets it commit or kills it.
class Writer {
  public:
    explicit Writer(const fs::path& output)
    {
        std::array<int, 2> ends{};
        if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) throw std::runtime_error("no socket");
        mProcess = ::fork();
        if (mProcess == 0) write(output, ends[1]);
        ::close(ends[1]);
        mSocket = ends[0];
        char begun = 0;
        if (::read(mSocket, &begun, 1) != 1) throw std::runtime_error("the other process cannot write");
    }
    ~Writer()
    {
        if (mProcess > 0) kill();
        ::close(mSocket);
    }
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;

    void kill()
    {
        ::kill(mProcess, SIGKILL);
        (void)wait();
    }
    /// @return whether the output was committed
    bool commit()
    {
        const char go = 1;
        return ::write(mSocket, &go, 1) == 1 && wait() == 0;
    }

  private:
    [[noreturn]] static void write(const fs::path& output, int socket)
    {
        try {
            AtomicFile file(output, kNamed);
            std::ofstream(file.temporary()) << "of the other process";
            char go = 1;
            if (::write(socket, &go, 1) != 1 || ::read(socket, &go, 1) != 1) ::_exit(1);
            file.commit();
            ::_exit(0);
        } catch (...) {
            ::_exit(1);
        }
    }
    int wait()
    {
        int status = -1;
        ::waitpid(std::exchange(mProcess, -1), &status, 0);
        return status;
    }
    pid_t mProcess = -1;
    int mSocket = -1;
};

TEST(AtomicFile, ReplacesAnOlderFileAndWhatAKilledProcessLeft)
{
    for (const auto kind : {AtomicFile::Temporary::kUnnamedIfPossible, kNamed}) {
        const TemporaryFolder folder;
        const fs::path final = folder.add("out.vdb", "old");
        {
            Writer first(final), second(final);
            EXPECT_EQ(fileCount(folder), 3u);
            first.kill();
            second.kill();
        }
        EXPECT_EQ(fileCount(folder), 3u);
        AtomicFile file(final, kind);
        std::ofstream(file.temporary(), std::ios::app) << "new";
        file.commit();
        EXPECT_EQ(textOf(final), "new");
        EXPECT_EQ(fileCount(folder), 1u);
    }
}

TEST(AtomicFile, HasAHiddenNameWhereItMustHaveOne)
{
    const TemporaryFolder folder;
    {
        AtomicFile file(folder / "out.vdb", kNamed);
        const std::string name = file.temporary().filename().string();
        EXPECT_TRUE(name.starts_with(".out.vdb.") && name.ends_with("-0.part")) << name;
        EXPECT_EQ(file.temporary().parent_path(), folder.path());
        EXPECT_TRUE(fs::exists(file.temporary()));
    }
    EXPECT_TRUE(folder.empty());
    EXPECT_NO_THROW(AtomicFile(folder / std::string(255, 'x'), kNamed).commit()); // the longest name possible
}

TEST(AtomicFile, OfTwoAtOnceTheLastStaysWhole)
{
    for (const auto kind : {AtomicFile::Temporary::kUnnamedIfPossible, kNamed}) {
        const TemporaryFolder folder;
        AtomicFile first(folder / "out.vdb", kind), second(folder / "out.vdb", kind);
        EXPECT_NE(first.temporary(), second.temporary());
        std::ofstream(first.temporary()) << "first";
        std::ofstream(second.temporary()) << "second";
        second.commit();
        EXPECT_EQ(textOf(folder / "out.vdb"), "second");
        first.commit();
        EXPECT_EQ(textOf(folder / "out.vdb"), "first");
        EXPECT_EQ(fileCount(folder), 1u);
    }
}

TEST(AtomicFile, LeavesTheFileOfALivingProcessAlone)
{
    for (const auto kind : {AtomicFile::Temporary::kUnnamedIfPossible, kNamed}) {
        const TemporaryFolder folder;
        Writer other(folder / "out.vdb");
        AtomicFile own(folder / "out.vdb", kind);
        std::ofstream(own.temporary()) << "own";
        own.commit();
        EXPECT_EQ(textOf(folder / "out.vdb"), "own");
        EXPECT_EQ(fileCount(folder), 2u);
        EXPECT_TRUE(other.commit());
        EXPECT_EQ(textOf(folder / "out.vdb"), "of the other process");
        EXPECT_EQ(fileCount(folder), 1u);
    }
}

TEST(AtomicFile, LeavesTheFilesOfOtherHostsAlone)
{
    const TemporaryFolder folder;
    folder.add(".out.vdb.elsewhere.example-0.part", "half");
    AtomicFile(folder / "out.vdb", kNamed).commit();
    EXPECT_EQ(textOf(folder / ".out.vdb.elsewhere.example-0.part"), "half");
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
    EXPECT_THROW(AtomicFile{folder.path()}, ParameterError);
    EXPECT_THROW(AtomicFile{"/dev/null"}, ParameterError);
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
    EXPECT_EQ(fileCount(folder), 2u); // the destructor removes the hidden one
}

} // namespace
} // namespace vdblic
