#include "vdblic/io/vdb_parser.h"

#include "io/varied_grid.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/leaf_list.h"
#include "vdblic/io/leaf_record.h"
#include "vdblic/io/vdb_assembly.h"

#include <gtest/gtest.h>

#include <openvdb/io/Compression.h>
#include <openvdb/io/Stream.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ios>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

namespace io = openvdb::io;

std::string written(const openvdb::GridCPtrVec& grids, std::uint32_t compression)
{
    std::ostringstream stream;
    io::Stream writer(stream);
    writer.setCompression(compression);
    writer.write(grids);
    return stream.str();
}

VdbFile parsed(const std::string& bytes, const LeafFilter& isKept = {})
{
    std::istringstream stream(bytes);
    stream.exceptions(std::ios::failbit | std::ios::badbit);
    return parseVdb(stream, "a.vdb", bytes.size(), isKept);
}

/// Parsing gives the grid that OpenVDB reads, to the bit: of a type, with its metadata, nodes and values.
template<typename GridT>
void expectTheGridOfOpenVdb(const typename GridT::Ptr& grid)
{
    for (const std::uint32_t compression : {io::COMPRESS_BLOSC, io::COMPRESS_ZIP, io::COMPRESS_NONE}) {
        for (const std::uint32_t activeOnly : {io::COMPRESS_NONE, io::COMPRESS_ACTIVE_MASK}) {
            const std::string bytes = written({grid}, compression | activeOnly);
            std::istringstream stream(bytes);
            const auto wanted = openvdb::gridPtrCast<GridT>(io::Stream(stream).getGrids()->front());
            const VdbFile file = parsed(bytes);
            ASSERT_EQ(file.grids.size(), 1u);
            const openvdb::GridBase& stored = *file.grids.front();
            EXPECT_EQ(typeid(stored), typeid(GridT));
            const auto found = openvdb::gridPtrCast<GridT>(file.grids.front());
            EXPECT_EQ(static_cast<const openvdb::MetaMap&>(*found), *wanted);
            EXPECT_EQ(found->background(), wanted->background());
            ASSERT_TRUE(found->tree().hasSameTopology(wanted->tree()));
            for (auto value = wanted->cbeginValueAll(), same = found->cbeginValueAll(); value; ++value, ++same)
                ASSERT_EQ(*same, *value) << grid->getName() << value.getCoord() << compression << activeOnly;
        }
    }
}

TEST(VdbParser, ReadsWhatOpenVdbReads)
{
    expectTheGridOfOpenVdb<openvdb::FloatGrid>(variedGrid<openvdb::FloatGrid>("float"));
    expectTheGridOfOpenVdb<openvdb::DoubleGrid>(variedGrid<openvdb::DoubleGrid>("double"));
    expectTheGridOfOpenVdb<openvdb::Vec3SGrid>(variedGrid<openvdb::Vec3SGrid>("vec3s"));
    expectTheGridOfOpenVdb<openvdb::Vec3DGrid>(variedGrid<openvdb::Vec3DGrid>("vec3d"));
    expectTheGridOfOpenVdb<openvdb::Vec3IGrid>(variedGrid<openvdb::Vec3IGrid>("vec3i"));
    expectTheGridOfOpenVdb<openvdb::Int32Grid>(variedGrid<openvdb::Int32Grid>("int32"));
    expectTheGridOfOpenVdb<openvdb::Int64Grid>(variedGrid<openvdb::Int64Grid>("int64"));
    expectTheGridOfOpenVdb<openvdb::BoolGrid>(variedGrid<openvdb::BoolGrid>("bool"));
    expectTheGridOfOpenVdb<openvdb::FloatGrid>(openvdb::FloatGrid::create(2));
}

TEST(VdbParser, ReadsTheFormatOfOpenVdb13WithoutAWord)
{
    const auto grid = variedGrid<openvdb::FloatGrid>("v");
    std::string bytes = written({grid}, io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK);
    constexpr std::uint32_t kFormat = 225;
    std::memcpy(bytes.data() + sizeof(std::int64_t), &kFormat, sizeof kFormat);
    testing::internal::CaptureStdout();
    const VdbFile file = parsed(bytes);
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    EXPECT_TRUE(file.find<openvdb::FloatGrid>("v")->tree().hasSameTopology(grid->tree()));
}

/// The leaves in a box have the values that the whole file gives them, and the others none.
template<typename GridT>
void expectLeavesInBox(const VdbFile& part, const VdbFile& whole, const std::string& name,
                       const openvdb::CoordBBox& box)
{
    const auto all = whole.find<GridT>(name), some = part.find<GridT>(name);
    ASSERT_TRUE(some->tree().hasSameTopology(all->tree()));
    std::size_t inside = 0;
    for (auto leaf = some->tree().cbeginLeaf(); leaf; ++leaf) {
        const bool isInside = box.isInside(leaf->origin());
        inside += isInside;
        EXPECT_EQ(leaf->buffer().empty(), !isInside) << name;
        if (!isInside) continue;
        EXPECT_EQ(*leaf, *all->tree().probeConstLeaf(leaf->origin())) << name;
    }
    EXPECT_GT(inside, 20u);
    EXPECT_LT(inside, some->tree().leafCount());
}

TEST(VdbParser, ReadsTheLeavesThatAFilterKeeps)
{
    const auto half = variedGrid<openvdb::FloatGrid>("half");
    half->setSaveFloatAsHalf(true);
    const openvdb::GridCPtrVec grids = {variedGrid<openvdb::Vec3SGrid>("vectors"), half,
                                        variedGrid<openvdb::DoubleGrid>("doubles"),
                                        variedGrid<openvdb::Int32Grid>("integers")};
    const openvdb::CoordBBox box(openvdb::Coord(-8, 16, 0), openvdb::Coord(31, 47, 4095));
    const LeafFilter isKept = [&](const openvdb::GridBase& grid, const openvdb::Coord& origin) {
        return grid.getName() == "integers" || box.isInside(origin);
    };
    for (const std::uint32_t compression : {io::COMPRESS_BLOSC, io::COMPRESS_ZIP, io::COMPRESS_NONE}) {
        std::stringstream listed; // with the sizes of leaves
        VdbAssembly(compression | io::COMPRESS_ACTIVE_MASK).assemble(listed, grids, {});
        for (const std::string& bytes : {written(grids, compression | io::COMPRESS_ACTIVE_MASK), listed.str()}) {
            const VdbFile whole = parsed(bytes), part = parsed(bytes, isKept);
            expectLeavesInBox<openvdb::Vec3SGrid>(part, whole, "vectors", box);
            expectLeavesInBox<openvdb::FloatGrid>(part, whole, "half", box);
            expectLeavesInBox<openvdb::DoubleGrid>(part, whole, "doubles", box);
            for (auto leaf = part.find<openvdb::Int32Grid>("integers")->tree().cbeginLeaf(); leaf; ++leaf)
                EXPECT_FALSE(leaf->buffer().empty());
        }
    }
}

/// Counts the bytes that are read.
class CountingBuffer : public std::stringbuf {
  public:
    using std::stringbuf::stringbuf;
    std::streamsize count = 0;

  protected:
    std::streamsize xsgetn(char* bytes, std::streamsize number) override
    {
        count += number;
        return std::stringbuf::xsgetn(bytes, number);
    }
};

TEST(VdbParser, PassesOverWhatIsNotNeeded)
{
    if (!kHasLeafList) GTEST_SKIP() << "this OpenVDB lists no leaves";
    openvdb::initialize();
    auto noise = openvdb::Vec3SGrid::create(openvdb::Vec3f(0));
    noise->setName("v");
    auto accessor = noise->getAccessor();
    for (auto voxel = openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(255, 31, 31)).begin(); voxel; ++voxel) {
        const auto number = float((*voxel)[0] * 7919 % 1009 + (*voxel)[1] * 31 + (*voxel)[2]);
        accessor.setValue(*voxel, openvdb::Vec3f(number, 1 / number, number * number));
    }
    std::stringstream stream;
    VdbAssembly(io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK).assemble(stream, {noise}, {});
    const std::string bytes = stream.str();
    CountingBuffer buffer(bytes);
    std::istream counted(&buffer);
    counted.exceptions(std::ios::failbit | std::ios::badbit);
    const openvdb::CoordBBox box(openvdb::Coord(128, 0, 0), openvdb::Coord(159, 31, 31));
    const VdbFile part = parseVdb(counted, "a.vdb", bytes.size(),
                                  [&](const openvdb::GridBase&, const openvdb::Coord& at) { return box.isInside(at); });
    expectLeavesInBox<openvdb::Vec3SGrid>(part, parsed(bytes), "v", box);
    EXPECT_LT(buffer.count, std::streamsize(bytes.size() / 4)); // an eighth of the leaves
    EXPECT_GT(buffer.count, std::streamsize(bytes.size() / 9));
}

/// Gives the leaves of one grid with a list of sizes that is not true.
class LyingSource final : public LeafSource {
  public:
    explicit LyingSource(StoredLeaves leaves) : mLeaves(std::move(leaves)) {}
    [[nodiscard]] std::size_t grids() const override { return 1; }
    StoredLeaves leaves() override { return {{}, mLeaves.lengths, mLeaves.kinds, mLeaves.sizes}; }
    std::string block() override { return mNext < mLeaves.blocks.size() ? mLeaves.blocks[mNext++] : std::string(); }

  private:
    StoredLeaves mLeaves;
    std::size_t mNext = 0;
};

TEST(VdbParser, IsNotLedAstrayByAListOfSizes)
{
    if (!kHasLeafList) GTEST_SKIP() << "this OpenVDB lists no leaves";
    const auto grid = variedGrid<openvdb::FloatGrid>("v");
    std::vector<const openvdb::FloatTree::LeafNodeType*> leaves;
    grid->tree().getNodes(leaves);
    const VdbAssembly assembly(io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK);
    const StoredLeaves honest = assembly.store(*grid, leaves);
    const openvdb::CoordBBox box(openvdb::Coord(-8, 16, 0), openvdb::Coord(31, 47, 4095));
    const auto isKept = [&](const openvdb::GridBase&, const openvdb::Coord& at) { return box.isInside(at); };
    const auto parsedWith = [&](const StoredLeaves& list) {
        std::stringstream stream;
        LyingSource source(list);
        assembly.assemble(stream, {grid}, {}, &source);
        return parsed(stream.str(), isKept);
    };
    const VdbFile whole = parsed(written({grid}, io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK));
    expectLeavesInBox<openvdb::FloatGrid>(parsedWith(honest), whole, "v", box);

    StoredLeaves wrong = honest; // does not add up: bytes are passed over
    ++wrong.sizes.front();
    expectLeavesInBox<openvdb::FloatGrid>(parsedWith(wrong), whole, "v", box);
    wrong = honest; // is too short
    wrong.sizes.pop_back();
    wrong.kinds.pop_back();
    expectLeavesInBox<openvdb::FloatGrid>(parsedWith(wrong), whole, "v", box);
    wrong = honest; // leads beyond the file and back
    wrong.sizes.front() += std::int64_t(1) << 40;
    wrong.sizes.back() -= std::int64_t(1) << 40;
    expectLeavesInBox<openvdb::FloatGrid>(parsedWith(wrong), whole, "v", box);
    wrong = honest; // adds up, but leads into the midst of leaves
    wrong.sizes.front() += 100;
    *std::max_element(wrong.sizes.begin() + 1, wrong.sizes.end()) -= 100;
    EXPECT_ANY_THROW(parsedWith(wrong));
}

TEST(VdbParser, ReadsWhatOpenVdbReadsOfHalfFloats)
{
    const auto half = [](auto grid) {
        grid->setSaveFloatAsHalf(true);
        return grid;
    };
    expectTheGridOfOpenVdb<openvdb::FloatGrid>(half(variedGrid<openvdb::FloatGrid>("float")));
    expectTheGridOfOpenVdb<openvdb::DoubleGrid>(half(variedGrid<openvdb::DoubleGrid>("double")));
    expectTheGridOfOpenVdb<openvdb::Vec3SGrid>(half(variedGrid<openvdb::Vec3SGrid>("vec3s")));
    expectTheGridOfOpenVdb<openvdb::Vec3DGrid>(half(variedGrid<openvdb::Vec3DGrid>("vec3d")));
    expectTheGridOfOpenVdb<openvdb::Int32Grid>(half(variedGrid<openvdb::Int32Grid>("int32")));
}

TEST(VdbParser, GridsOfOneTreeShareIt)
{
    const auto grid = variedGrid<openvdb::FloatGrid>("a"), instance = openvdb::FloatGrid::create(grid->treePtr());
    instance->setName("b");
    const VdbFile file = parsed(written({grid, instance}, io::COMPRESS_BLOSC));
    ASSERT_EQ(file.grids.size(), 2u);
    EXPECT_EQ(&file.grids[0]->baseTree(), &file.grids[1]->baseTree());
    EXPECT_EQ(file.grids[1]->getName(), "b");
}

/// The records of a grid's leaves, one after the other.
template<typename GridT>
std::string leafRecords(const GridT& grid, std::uint32_t compression)
{
    std::ostringstream stream;
    io::setDataCompression(stream, compression);
    io::setGridBackgroundValuePtr(stream, &grid.background());
    grid.tree().writeBuffers(stream, grid.saveFloatAsHalf());
    return stream.str();
}

TEST(LeafRecord, CutsRecordsOfEveryKind)
{
    const auto grid = variedGrid<openvdb::FloatGrid>("float");
    constexpr std::uint32_t kFlags = io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK;
    const std::string bytes = leafRecords(*grid, kFlags);
    std::istringstream stream(bytes);
    const LeafFormat format = LeafFormat::of<float>(kFlags, false);
    std::vector<char> records;
    std::set<int> kinds;
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
        const std::size_t begin = records.size();
        appendLeafRecord(stream, format, bytes.size(), records);
        std::ostringstream mask;
        leaf->valueMask().save(mask);
        EXPECT_EQ(std::string(records.data() + begin, LeafFormat::kMaskBytes), mask.str());
        kinds.insert(records[begin + LeafFormat::kMaskBytes]);
    }
    EXPECT_EQ(std::string(records.begin(), records.end()), bytes);
    EXPECT_EQ(kinds, (std::set<int>{0, 1, 2, 3, 4, 5, 6}));
}

TEST(LeafRecord, RefusesSizesThatCannotBe)
{
    const auto grid = openvdb::FloatGrid::create();
    grid->tree().touchLeaf(openvdb::Coord(0))->setValuesOn();
    constexpr std::size_t kSizeAt = LeafFormat::kMaskBytes + 1;
    const std::string good = leafRecords(*grid, io::COMPRESS_BLOSC);
    const auto append = [&](std::int64_t size) {
        std::string bytes = good;
        std::memcpy(bytes.data() + kSizeAt, &size, sizeof size);
        bytes.resize(10000);
        std::istringstream stream(bytes);
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        std::vector<char> record;
        appendLeafRecord(stream, LeafFormat::of<float>(io::COMPRESS_BLOSC, false), bytes.size(), record);
        return record.size();
    };
    constexpr std::size_t kHead = kSizeAt + 8;
    EXPECT_EQ(append(100), kHead + 100);
    EXPECT_EQ(append(-2048), kHead + 2048); // not compressed
    EXPECT_THROW(append(10000), std::ios::failure);
    for (const std::int64_t size :
         {std::int64_t(0), std::int64_t(-2047), std::int64_t(-2049), std::int64_t(10001), INT64_MAX, INT64_MIN}) {
        EXPECT_THROW(append(size), InputError) << size;
    }
}

TEST(VdbParser, DamageIsAnErrorInAnyThread)
{
    const auto grid = variedGrid<openvdb::FloatGrid>("float");
    const std::string good = written({grid}, io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK);
    for (const std::size_t threads : {1, 4}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        std::string damaged = good;
        for (std::size_t i = good.size() - 20000; i < good.size(); i += 7)
            damaged[i] = char(~damaged[i]);
        EXPECT_THROW((void)parsed(damaged), std::exception);
        EXPECT_THROW((void)parsed(good.substr(0, good.size() - 20)), std::ios::failure);
        EXPECT_NO_THROW((void)parsed(good));
    }
}

} // namespace
} // namespace vdblic
