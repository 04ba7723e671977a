#include "vdblic/io/vdb_file.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/version.h"
#include "vdblic/io/vdb_header.h"

#include <gtest/gtest.h>

#include <openvdb/io/File.h>

#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sys/resource.h>

namespace vdblic {
namespace {

openvdb::FloatGrid::Ptr someGrid(const char* name, int side)
{
    auto grid = openvdb::FloatGrid::create(-1);
    grid->setName(name);
    for (int i = 0; i < side * side * side; ++i) {
        grid->tree().setValue({i / (side * side) - 4, i / side % side, i % side}, float(i * 2654435761u));
    }
    return grid;
}

TEST(VdbFile, KeepsGridsAndMetadata)
{
    const TemporaryFolder folder;
    const auto density = someGrid("density", 12);
    density->setGridClass(openvdb::GRID_FOG_VOLUME);
    density->insertMeta("frame", openvdb::Int64Metadata(7));
    const auto transform = openvdb::math::Transform::createLinearTransform(
        openvdb::math::Mat4d(0., 2., 0., 0., -3., 0., 0., 0., 0., 0., .5, 0., 7., 8., 9., 1.));
    density->setTransform(transform);
    const auto velocity = openvdb::Vec3SGrid::create(openvdb::Vec3f(0));
    velocity->setName("velocity");
    velocity->tree().setValue({1, 2, 3}, {4, 5, 6});
    openvdb::MetaMap metadata;
    metadata.insertMeta("lifeSpan", openvdb::Int32Metadata(4));
    metadata.insertMeta("creator", openvdb::StringMetadata("Houdini/SOP")); // never carried over
    writeVdb(folder / "a b.vdb", {density, velocity}, metadata);

    const VdbFile file = readVdb(folder / "a b.vdb");
    ASSERT_EQ(file.grids.size(), 2u);
    EXPECT_EQ(file.metadata.metaValue<std::string>("creator"), kCreator);
    EXPECT_EQ(file.metadata.metaValue<std::int32_t>("lifeSpan"), 4);
    EXPECT_EQ(file.contents(), "density (float), velocity (vec3s)");

    const auto density2 = file.find<openvdb::FloatGrid>("density");
    ASSERT_TRUE(density2);
    EXPECT_EQ(density2->getGridClass(), openvdb::GRID_FOG_VOLUME);
    EXPECT_EQ(density2->transform(), *transform);
    EXPECT_EQ(density2->background(), -1);
    EXPECT_EQ(numericMetadata(*density2, "frame"), 7);
    ASSERT_TRUE(density2->tree().hasSameTopology(density->tree()));
    for (auto voxel = density->cbeginValueOn(); voxel; ++voxel) {
        ASSERT_EQ(density2->tree().getValue(voxel.getCoord()), *voxel);
    }
    EXPECT_EQ(file.find<openvdb::Vec3SGrid>("velocity")->tree().getValue({1, 2, 3}), openvdb::Vec3f(4, 5, 6));
    EXPECT_FALSE(file.find<openvdb::FloatGrid>("velocity"));
    EXPECT_FALSE(file.find<openvdb::FloatGrid>("none"));
}

TEST(VdbFile, FindsGridsByNameAndTypeOrSaysWhatThereIs)
{
    const auto wide = openvdb::DoubleGrid::create(), single = openvdb::DoubleGrid::create();
    const auto narrow = openvdb::FloatGrid::create();
    wide->setName("a");
    narrow->setName("a");
    single->setName("b");
    const VdbFile file{{wide, narrow, single}, {}, "f.vdb"};
    EXPECT_EQ(file.get<openvdb::FloatGrid>("a"), narrow);
    EXPECT_EQ(file.get<openvdb::GridBase>("a"), wide);
    EXPECT_EQ(file.find<openvdb::FloatGrid>("b"), nullptr);
    const auto message = [&](const auto& get) -> std::string {
        try {
            get();
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(message([&] { (void)file.get<openvdb::FloatGrid>("b", "`texture`"); }),
              "f.vdb: no float grid 'b'; present: a (double), a (float), b (double); choose with `texture`");
    EXPECT_EQ(message([&] { (void)file.get<openvdb::GridBase>("c"); }),
              "f.vdb: no grid 'c'; present: a (double), a (float), b (double)");
}

TEST(VdbFile, CreatorIsNotTakenForHoudini)
{
    EXPECT_FALSE(std::string(kCreator).starts_with("Houdini"));
}

TEST(VdbFile, LeavesOutMetadataOfOtherTypesThanOpenVdbs)
{
    const auto grid = someGrid("density", 4);
    grid->insertMeta("note", openvdb::Int32Metadata(1)); // what OpenVDB does not keep may be of any type
    for (const char* key : {"class", "is_local_space", "is_saved_as_half_float", "vector_type", "file_bbox_min"}) {
        const auto damaged = grid->deepCopy();
        damaged->removeMeta(key);
        damaged->insertMeta(key, openvdb::Int32Metadata(1));
        removeForeignMetadata({damaged});
        EXPECT_FALSE((*damaged)[key]) << key;
        EXPECT_TRUE((*damaged)["note"]);
    }
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    removeForeignMetadata({grid});
    EXPECT_EQ(grid->getGridClass(), openvdb::GRID_FOG_VOLUME);
}

TEST(VdbFile, RefusesMissingAndDamagedFiles)
{
    const TemporaryFolder folder;
    const std::filesystem::path whole = folder / "whole.vdb";
    writeVdb(whole, {someGrid("velocity", 16), someGrid("density", 16)}, {});
    EXPECT_EQ(readVdb(whole).contents(), "velocity (float), density (float)");
    const auto size = std::filesystem::file_size(whole);
    const std::filesystem::path cut = folder / "cut.vdb";
    // Many offsets in the header and the descriptors, and some in the voxels.
    for (std::uintmax_t length = 0; length < size; length += length < 1500 ? 11 : 9973) {
        std::filesystem::copy_file(whole, cut, std::filesystem::copy_options::overwrite_existing);
        std::filesystem::resize_file(cut, length);
        EXPECT_THROW((void)readVdb(cut), InputError) << length;
    }
    EXPECT_THROW((void)readVdb(folder / "none.vdb"), InputError);
    EXPECT_THROW((void)readVdb(folder.path()), InputError);
    EXPECT_THROW((void)readVdb(folder.add("text.vdb", "this is no volume")), InputError);
    try {
        (void)readVdb(folder.add("bell\a.vdb", "this is no volume"));
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("bell"), std::string::npos) << error.what();
    }
}

/// A file whose last node states a size of its values that is larger than the buffer for them.
template<typename Grid>
void expectNoOverflow(bool half, std::uint32_t compression, int bytes)
{
    SCOPED_TRACE(fmt::format("{} half {} compression {}", Grid::gridType(), half, compression));
    const TemporaryFolder folder;
    const auto first = openvdb::FloatGrid::create();
    const auto grid = Grid::create();
    for (int i = 0; i < 11; ++i)
        grid->tree().setValue({0, i % 8, i / 8}, typename Grid::ValueType(i));
    grid->setName("last");
    grid->setSaveFloatAsHalf(half);
    {
        openvdb::io::File file((folder / "a.vdb").string());
        file.setCompression(compression);
        file.write(openvdb::GridPtrVec{first, grid});
    }
    EXPECT_EQ(readVdb(folder / "a.vdb").grids.size(), 2u);

    std::ifstream file(folder / "a.vdb", std::ios::binary);
    std::string content{std::istreambuf_iterator<char>(file), {}};
    const auto sizeAt = [&](std::size_t offset) {
        std::int64_t size = 0;
        std::memcpy(&size, content.data() + offset, sizeof size);
        return size;
    };
    std::size_t offset = content.size() - 9; // the last size counts all bytes after it
    while (std::abs(sizeAt(offset)) != std::int64_t(content.size() - offset - 8))
        --offset;
    const std::int64_t wrong = -bytes - 2;
    std::memcpy(content.data() + offset, &wrong, sizeof wrong);
    content.append(std::size_t(-wrong), 'x');
    try {
        (void)readVdb(folder.add("b.vdb", content));
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find(fmt::format("size of {} bytes", -wrong)), std::string::npos)
            << error.what();
    }
}

TEST(VdbFile, ReadsNoMoreThanThereIsRoomFor)
{
    openvdb::initialize();
    using namespace openvdb::io;
    for (const std::uint32_t how : {COMPRESS_ZIP, COMPRESS_BLOSC}) {
        expectNoOverflow<openvdb::FloatGrid>(false, how, 512 * 4);
        expectNoOverflow<openvdb::FloatGrid>(false, how | COMPRESS_ACTIVE_MASK, 11 * 4);
        expectNoOverflow<openvdb::FloatGrid>(true, how | COMPRESS_ACTIVE_MASK, 11 * 2);
        expectNoOverflow<openvdb::Vec3SGrid>(false, how | COMPRESS_ACTIVE_MASK, 11 * 12);
        expectNoOverflow<openvdb::Vec3SGrid>(true, how | COMPRESS_ACTIVE_MASK, 11 * 6);
    }
}

/// Limits the size of this process's files during its lifetime; writing more fails as on a full disk.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(rlim_t bytes) : mHandler(std::signal(SIGXFSZ, SIG_IGN))
    {
        ::getrlimit(RLIMIT_FSIZE, &mBefore);
        const rlimit limit{bytes, mBefore.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit()
    {
        ::setrlimit(RLIMIT_FSIZE, &mBefore);
        std::signal(SIGXFSZ, mHandler);
    }

  private:
    void (*mHandler)(int);
    rlimit mBefore{};
};

TEST(VdbFile, AFullDiskLeavesAllAsItWas)
{
    const TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.vdb";
    const auto small = someGrid("small", 4), big = someGrid("big", 40);
    std::string message;
    const auto writeBig = [&] {
        const FileSizeLimit limit(20000);
        try {
            writeVdb(path, {big}, {});
        } catch (const OutputError& error) {
            message = error.what();
        }
    };
    writeBig();
    EXPECT_EQ(message, path.string() + ": cannot be written: File too large");
    EXPECT_TRUE(folder.empty());

    writeVdb(path, {small}, {});
    message.clear();
    writeBig();
    EXPECT_NE(message, "");
    EXPECT_EQ(readVdb(path).contents(), "small (float)");
    writeVdb(path, {big}, {});
    EXPECT_EQ(readVdb(path).contents(), "big (float)");
}

TEST(VdbFile, SaysWhenTheFolderIsMissingOrInTheWay)
{
    const TemporaryFolder folder;
    EXPECT_THROW(writeVdb(folder / "none/a.vdb", {someGrid("density", 4)}, {}), OutputError);
    EXPECT_THROW(writeVdb(folder.path(), {someGrid("density", 4)}, {}), ParameterError);
    EXPECT_TRUE(folder.empty());
}

TEST(NumericMetadata, ReadsEveryNumericType)
{
    openvdb::MetaMap metadata;
    metadata.insertMeta("double", openvdb::DoubleMetadata(0.1));
    metadata.insertMeta("float", openvdb::FloatMetadata(0.5f));
    metadata.insertMeta("int", openvdb::Int32Metadata(-3));
    metadata.insertMeta("long", openvdb::Int64Metadata(1LL << 40));
    metadata.insertMeta("text", openvdb::StringMetadata("1"));
    EXPECT_EQ(numericMetadata(metadata, "double"), 0.1);
    EXPECT_EQ(numericMetadata(metadata, "float"), 0.5);
    EXPECT_EQ(numericMetadata(metadata, "int"), -3);
    EXPECT_EQ(numericMetadata(metadata, "long"), double(1LL << 40));
    EXPECT_EQ(numericMetadata(metadata, "text"), std::nullopt);
    EXPECT_EQ(numericMetadata(metadata, "none"), std::nullopt);
}

} // namespace
} // namespace vdblic
