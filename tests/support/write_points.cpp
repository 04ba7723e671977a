/// Writes a PointDataGrid, compressed and not: `write_points COMPRESSED PLAIN`. pyopenvdb cannot, and vdb_tool writes
/// points that have no values.
#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>

#include <cmath>
#include <cstdio>

int main(int argc, char** argv)
{
    if (argc != 3) {
        std::fprintf(stderr, "usage: write_points COMPRESSED PLAIN\n");
        return 2;
    }
    openvdb::initialize();
    std::vector<openvdb::Vec3f> positions;
    std::vector<float> masses;
    for (int i = 0; i < 1500; ++i) {
        const auto t = float(i);
        positions.emplace_back(6 * std::sin(t), 6 * std::cos(1.7f * t), 0.01f * t);
        masses.push_back(0.5f * t);
    }
    const auto transform = openvdb::math::Transform::createLinearTransform(0.5);
    const openvdb::points::PointAttributeVector<openvdb::Vec3f> places(positions);
    const auto index = openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(places, *transform);
    auto grid =
        openvdb::points::createPointDataGrid<openvdb::points::FixedPointCodec<false>, openvdb::points::PointDataGrid>(
            *index, places, *transform);
    openvdb::points::appendAttribute<float>(grid->tree(), "mass");
    openvdb::points::populateAttribute(grid->tree(), index->tree(), "mass",
                                       openvdb::points::PointAttributeVector<float>(masses));
    grid->setName("points");
    openvdb::io::File(argv[1]).write({grid});
    openvdb::io::File plain(argv[2]);
    plain.setCompression(openvdb::io::COMPRESS_NONE);
    plain.write({grid});
}
