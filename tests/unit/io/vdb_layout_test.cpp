#include "vdblic/io/vdb_layout.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/vdb_file.h"

#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>

#include <cstddef>
#include <cstring>
#include <fstream>
#include <sstream>

namespace vdblic {
namespace {

openvdb::GridCPtrVec someGrids()
{
    openvdb::initialize();
    const auto fog = openvdb::FloatGrid::create();
    fog->setName("fog");
    fog->fill(openvdb::CoordBBox({0, 0, 0}, {20, 9, 9}), 0.5f);
    fog->tree().voxelizeActiveTiles();
    const auto flow = openvdb::Vec3SGrid::create();
    flow->setName("flow");
    flow->tree().setValue({1, 2, 3}, {1, 2, 3});
    const auto frustum = openvdb::FloatGrid::create();
    frustum->setName("fog"); // a duplicate name
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform({{0, 0, 0}, {9, 9, 9}}, 0.5, 2));
    return {fog, flow, frustum};
}

/// The bytes of a file written by OpenVDB, without this library's additions.
std::string foreignFile(bool seekable = true)
{
    const TemporaryFolder folder;
    std::ostringstream bytes;
    if (!seekable) {
        openvdb::io::Stream(bytes).write(someGrids());
        return bytes.str();
    }
    const std::string path = folder / "a.vdb";
    openvdb::io::File(path).write(someGrids());
    bytes << std::ifstream(path, std::ios::binary).rdbuf();
    return bytes.str();
}

VdbLayout layoutOf(const std::string& bytes)
{
    std::istringstream stream(bytes);
    return readLayout(stream, bytes.size());
}

/// The reason why a file is refused; empty if it is accepted.
std::string complaint(const std::string& bytes)
{
    try {
        (void)layoutOf(bytes);
        return "";
    } catch (const InputError& error) {
        return error.what();
    }
}

/// A file with the bytes at an offset replaced.
template<typename T>
std::string with(std::string bytes, std::size_t offset, T value)
{
    std::memcpy(bytes.data() + offset, &value, sizeof value);
    return bytes;
}

TEST(VdbLayout, FindsTheGridsOfAFile)
{
    const std::string bytes = foreignFile();
    const VdbLayout layout = layoutOf(bytes);
    ASSERT_EQ(layout.grids.size(), 3u);
    EXPECT_EQ(layout.grids[0].name, "fog");
    EXPECT_EQ(layout.grids[1].name, "flow");
    EXPECT_EQ(layout.grids[2].name, "fog");
    EXPECT_EQ(layout.grids[1].type, "Tree_vec3s_5_4_3");
    EXPECT_EQ(layout.grids[0].begin, layout.headerEnd);
    EXPECT_EQ(layout.grids[1].begin, layout.grids[0].end);
    EXPECT_EQ(layout.grids[2].end, bytes.size());
    EXPECT_GT(layout.grids[0].memory, 12000u); // six leaves of 2 KB
    EXPECT_EQ(layout.identity.size(), 36u);
    EXPECT_EQ(layout.checksum.text, "");
}

TEST(VdbLayout, TakesFilesWithoutOffsets)
{
    EXPECT_FALSE(layoutOf(foreignFile(false)).seekable);
}

TEST(VdbLayout, RefusesEveryTruncation)
{
    const std::string bytes = foreignFile();
    for (std::size_t length = 0; length < bytes.size(); ++length)
        ASSERT_NE(complaint(bytes.substr(0, length)), "") << length;
}

TEST(VdbLayout, SurvivesEveryFlip)
{
    // Some offsets make the file invalid, others do not; nothing may be read or allocated beyond the file.
    const std::string bytes = foreignFile();
    int refused = 0;
    for (std::size_t offset = 0; offset < std::min<std::size_t>(bytes.size(), 3000); ++offset) {
        for (const int flip : {0x01, 0x80, 0xff}) {
            std::string flipped = bytes;
            flipped[offset] = char(flipped[offset] ^ flip);
            refused += complaint(flipped).empty() ? 0 : 1;
        }
    }
    EXPECT_GT(refused, 400);
}

TEST(VdbLayout, SaysWhatIsWrong)
{
    const std::string bytes = foreignFile();
    const VdbLayout layout = layoutOf(bytes);
    constexpr std::size_t kVersion = 8, kMetadata = 21 + 36;
    EXPECT_EQ(complaint(""), "it is no .vdb file");
    EXPECT_EQ(complaint("PK\3\4 and more, as other formats begin"), "it is no .vdb file");
    EXPECT_EQ(complaint(bytes.substr(0, 30)), "it ends too early, in the header");
    EXPECT_EQ(complaint(with(bytes, kVersion, 300u)), "it has the format version 300; 218 to 225 can be read");
    EXPECT_EQ(complaint(with(bytes, kMetadata, 0x7fffffffu)), "it says to have 2147483647 metadata");
    const std::size_t count = layout.headerEnd - 4;
    EXPECT_EQ(complaint(with(bytes, count, -1)), "it says to have -1 grids");
    EXPECT_EQ(complaint(with(bytes, count, 1'000'000)), "it says to have 1000000 grids");
    const std::size_t name = layout.grids[1].begin;
    EXPECT_EQ(complaint(with(bytes, name, 0xfffffff0u)),
              "a grid's name has a length of 4294967280, which is impossible");
    const std::size_t offsets = name + 4 + 4 + 4 + layout.grids[1].type.size() + 4; // after name, type, instance
    EXPECT_NE(complaint(with(bytes, offsets + 8, std::int64_t(bytes.size()) + 1)).find("do not lie in order"),
              std::string::npos);
    EXPECT_NE(complaint(bytes.substr(0, bytes.size() - 1)).find("it is truncated"), std::string::npos);
    EXPECT_NE(complaint(with(bytes, offsets, std::int64_t(-1))).find("of grid 'flow'"), std::string::npos);
    std::string frustum = bytes;
    frustum[frustum.find("NonlinearFrustumMap")] = 'M';
    EXPECT_EQ(complaint(frustum), "a transform is of the type 'MonlinearFrustumMap', which there is not");
}

} // namespace
} // namespace vdblic
