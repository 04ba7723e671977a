#include "vdblic/io/checksum.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <filesystem>
#include <fstream>
#include <istream>

namespace vdblic {
namespace {

openvdb::FloatGrid::Ptr someGrid(const std::string& name)
{
    openvdb::initialize();
    auto grid = openvdb::FloatGrid::create();
    grid->setName(name);
    for (int i = 0; i < 4096; ++i)
        grid->tree().setValue({i / 256, i / 16 % 16, i % 16}, float(i * 2654435761u));
    return grid;
}

VdbLayout layoutOf(const std::filesystem::path& path)
{
    std::ifstream stream(path, std::ios::binary);
    return readLayout(stream, std::filesystem::file_size(path));
}

void flip(const std::filesystem::path& path, std::uint64_t offset)
{
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(std::streamoff(offset));
    const char changed = char(file.get() ^ 1);
    file.seekp(std::streamoff(offset));
    file.put(changed);
}

std::string complaint(const std::filesystem::path& path)
{
    try {
        (void)readVdb(path);
        return "";
    } catch (const InputError& error) {
        return error.what();
    }
}

TEST(Checksum, NamesTheDamagedGrid)
{
    const TemporaryFolder folder;
    const auto path = folder / "a.vdb";
    const auto write = [&] { writeVdb(path, {someGrid("density"), someGrid("magnitude")}, {}); };
    write();
    EXPECT_TRUE(verifyVdb(path));
    const VdbLayout layout = layoutOf(path);
    // A flipped bit anywhere in a grid; in the payload only the checksum reveals it.
    for (const auto& grid : layout.grids) {
        for (std::uint64_t offset = grid.begin; offset < grid.end; offset += (grid.end - grid.begin) / 7) {
            write();
            flip(path, offset);
            EXPECT_NE(complaint(path), "") << offset;
        }
        write();
        flip(path, grid.end - 9);
        EXPECT_EQ(complaint(path),
                  fmt::format("{}: cannot be read as a .vdb file: grid '{}' is damaged: the checksum is "
                              "not that of its bytes; make or copy the file again",
                              path.string(), grid.name));
        EXPECT_THROW((void)verifyVdb(path), InputError);
    }
    write();
    flip(path, layout.headerEnd - 6); // the last character of the file metadata
    EXPECT_NE(complaint(path).find("its header is damaged"), std::string::npos) << complaint(path);
    write();
    std::ofstream(path, std::ios::app) << "more";
    EXPECT_NE(complaint(path).find("its end is damaged"), std::string::npos) << complaint(path);
}

TEST(Checksum, IsNotTakenFromAFileThatAnotherProgramWrote)
{
    const TemporaryFolder folder;
    writeVdb(folder / "ours.vdb", {someGrid("density")}, {});
    // Another program loads the file, changes it, and keeps all metadata.
    openvdb::io::File file(folder / "ours.vdb");
    file.open();
    const auto grids = file.getGrids();
    openvdb::gridPtrCast<openvdb::FloatGrid>((*grids)[0])->tree().setValue({0, 0, 0}, 7);
    ASSERT_TRUE((*file.getMetadata())["checksum"]);
    openvdb::io::File(folder / "theirs.vdb").write(*grids, *file.getMetadata());
    EXPECT_FALSE(verifyVdb(folder / "theirs.vdb"));
    EXPECT_EQ(complaint(folder / "theirs.vdb"), "");
}

TEST(Checksum, OfEqualFilesIsEqualAndOfReadFilesForgotten)
{
    const TemporaryFolder folder;
    writeVdb(folder / "a.vdb", {someGrid("density")}, {});
    const VdbFile file = readVdb(folder / "a.vdb");
    EXPECT_FALSE(file.metadata["checksum"]);
    writeVdb(folder / "b.vdb", {someGrid("density")}, file.metadata);
    EXPECT_EQ(layoutOf(folder / "a.vdb").checksum.text, layoutOf(folder / "b.vdb").checksum.text);
    EXPECT_EQ(layoutOf(folder / "a.vdb").identity, layoutOf(folder / "b.vdb").identity);
    writeVdb(folder / "c.vdb", {someGrid("other")}, file.metadata);
    EXPECT_NE(layoutOf(folder / "a.vdb").identity, layoutOf(folder / "c.vdb").identity);
}

TEST(Checksum, WorksWithoutGrids)
{
    const TemporaryFolder folder;
    writeVdb(folder / "a.vdb", {}, {});
    EXPECT_TRUE(verifyVdb(folder / "a.vdb"));
    EXPECT_EQ(complaint(folder / "a.vdb"), "");
}

} // namespace
} // namespace vdblic
