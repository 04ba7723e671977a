#pragma once

#include <openvdb/io/Compression.h>
#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <vector>

namespace vdblic {

/// Grids whose leaves are stored one after the other, so that each can be compressed by itself. The leaves of points
/// share pages; those of bool and mask grids are masks, which are not compressed.
using LeafwiseGrids = openvdb::TypeList<openvdb::Int32Grid, openvdb::Int64Grid, openvdb::FloatGrid, openvdb::DoubleGrid,
                                        openvdb::Vec3IGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid>;

/// How the leaves of a grid are stored. A leaf's record has the mask of active voxels, a byte that says which inactive
/// values there are (its kind), up to two such values, a mask that selects between them, and the other values.
struct LeafFormat {
    std::uint32_t compression = 0; ///< flags of openvdb::io
    std::size_t inactiveBytes = 0; ///< of an inactive value
    std::size_t valueBytes = 0;    ///< of another value, before it is compressed
    bool half = false;

    template<typename ValueT>
    static LeafFormat of(std::uint32_t compression, bool half)
    {
        using Half = openvdb::io::RealToHalf<ValueT>;
        return {compression, sizeof(ValueT), half ? sizeof(typename Half::HalfT) : sizeof(ValueT),
                half && Half::isReal};
    }

    static constexpr std::size_t kMaskBytes = 64, kVoxels = 512;
    static constexpr std::uint32_t kCompressed = openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ZIP;

    /// The bytes of a record before the values. @param kind the byte at kMaskBytes
    [[nodiscard]] std::size_t headBytes(int kind) const;
};

/// Append the next record to `bytes`, after checking the size that it states for its values.
/// @param stream throws at its end  @param fileSize limits the size of a record
/// @throws InputError with the reason, but not the file
void appendLeafRecord(std::istream& stream, const LeafFormat& format, std::uint64_t fileSize, std::vector<char>& bytes);

} // namespace vdblic
