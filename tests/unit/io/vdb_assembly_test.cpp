#include "vdblic/io/vdb_assembly.h"

#include "io/varied_grid.h"
#include "vdblic/io/vdb_layout.h"

#include <gtest/gtest.h>

#include <openvdb/io/Archive.h>
#include <openvdb/io/Compression.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

namespace vdblic {
namespace {

/// OpenVDB's own writer.
class OwnArchive : public openvdb::io::Archive {
  public:
    explicit OwnArchive(std::uint32_t compression) { setCompression(compression); }
    void writeTo(std::ostream& stream, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const
    {
        openvdb::io::Archive::write(stream, grids, /*seekable=*/true, metadata);
    }
};

std::string withoutIdentity(std::string bytes)
{
    return bytes.replace(VdbLayout::kIdentityOffset, VdbLayout::kIdentityLength, VdbLayout::kIdentityLength, '-');
}

void expectTheBytesOfOpenVdb(const openvdb::GridCPtrVec& grids)
{
    openvdb::MetaMap metadata;
    metadata.insertMeta("frame", openvdb::Int32Metadata(3));
    for (const auto compression :
         {openvdb::io::COMPRESS_BLOSC, openvdb::io::COMPRESS_ZIP, openvdb::io::COMPRESS_NONE}) {
        const std::uint32_t flags = compression | openvdb::io::COMPRESS_ACTIVE_MASK;
        std::stringstream own, wanted;
        VdbAssembly(flags).assemble(own, grids, metadata);
        OwnArchive(flags).writeTo(wanted, grids, metadata);
        const std::string a = withoutIdentity(own.str()), b = withoutIdentity(wanted.str());
        ASSERT_EQ(a.size(), b.size()) << compression;
        EXPECT_TRUE(a == b) << compression << ", grid " << (grids.empty() ? "" : grids.front()->getName());
    }
}

TEST(VdbAssembly, WritesTheBytesOfOpenVdb)
{
    expectTheBytesOfOpenVdb({variedGrid<openvdb::FloatGrid>("float")});
    expectTheBytesOfOpenVdb({variedGrid<openvdb::DoubleGrid>("double")});
    expectTheBytesOfOpenVdb({variedGrid<openvdb::Vec3SGrid>("vec3s")});
    expectTheBytesOfOpenVdb({variedGrid<openvdb::Vec3DGrid>("vec3d")});
    expectTheBytesOfOpenVdb({variedGrid<openvdb::Vec3IGrid>("vec3i")});
    expectTheBytesOfOpenVdb({variedGrid<openvdb::Int32Grid>("int32")});
    expectTheBytesOfOpenVdb({variedGrid<openvdb::Int64Grid>("int64")});
    expectTheBytesOfOpenVdb({variedGrid<openvdb::BoolGrid>("bool")});
    const auto mask = openvdb::MaskGrid::create();
    mask->tree().topologyUnion(variedGrid<openvdb::FloatGrid>("")->tree());
    expectTheBytesOfOpenVdb({mask});
}

TEST(VdbAssembly, WritesTheBytesOfOpenVdbInHalfFloats)
{
    const auto expectHalf = [](const auto& grid) {
        for (const auto gridClass : {openvdb::GRID_UNKNOWN, openvdb::GRID_FOG_VOLUME, openvdb::GRID_LEVEL_SET}) {
            grid->setSaveFloatAsHalf(true);
            grid->setGridClass(gridClass);
            expectTheBytesOfOpenVdb({grid});
        }
    };
    expectHalf(variedGrid<openvdb::FloatGrid>("float"));
    expectHalf(variedGrid<openvdb::DoubleGrid>("double"));
    expectHalf(variedGrid<openvdb::Vec3SGrid>("vec3s"));
    expectHalf(variedGrid<openvdb::Vec3DGrid>("vec3d"));
    expectHalf(variedGrid<openvdb::Int32Grid>("int32"));
    expectHalf(openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(20, openvdb::Vec3f(3), 0.7f));
}

TEST(VdbAssembly, WritesTheBytesOfOpenVdbForSeveralGrids)
{
    const auto a = variedGrid<openvdb::FloatGrid>("a"), half = variedGrid<openvdb::FloatGrid>("b");
    half->setSaveFloatAsHalf(true);
    const auto instance = openvdb::FloatGrid::create(half->treePtr()),
               whole = openvdb::FloatGrid::create(half->treePtr());
    instance->setName("b");
    instance->setSaveFloatAsHalf(true);
    instance->setTransform(openvdb::math::Transform::createLinearTransform(3));
    const auto empty = openvdb::Vec3SGrid::create(openvdb::Vec3f(1));
    const std::vector<openvdb::Vec3f> places = {{1, 2, 3}, {40, 5, 6}, {41, 5, 6}};
    const auto points =
        openvdb::points::createPointDataGrid<openvdb::points::NullCodec, openvdb::points::PointDataGrid>(
            places, *openvdb::math::Transform::createLinearTransform(1));
    expectTheBytesOfOpenVdb({});
    expectTheBytesOfOpenVdb({empty});
    expectTheBytesOfOpenVdb({a, half, empty, points, instance, whole, a, openvdb::FloatGrid::create()});
}

} // namespace
} // namespace vdblic
