#pragma once

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace vdblic {

/// The leaves of a grid as a file stores them. They depend on their own values only, so several processes can store the
/// leaves of one grid.
struct StoredLeaves {
    std::vector<std::string> blocks;    ///< records of leaves, one after the other, in the tree's order
    std::vector<std::uint32_t> lengths; ///< of each leaf's record [bytes]
    std::vector<signed char> kinds;     ///< of each leaf (LeafFormat)
    std::vector<std::int64_t> sizes;    ///< of each leaf's values, as OpenVDB lists them; empty if it does not
};

enum class VdbCompression;
/// Store leaves of a grid as writeVdb() does. @tparam GridT a float or an int32 grid
template<typename GridT>
[[nodiscard]] StoredLeaves storeLeaves(const GridT& grid,
                                       const std::vector<const typename GridT::TreeType::LeafNodeType*>& leaves,
                                       VdbCompression compression);

/// Gives VdbAssembly::assemble() the leaves of the first grids of a file, while the file is being written.
class LeafSource {
  public:
    virtual ~LeafSource() = default;
    /// The number of those grids.
    [[nodiscard]] virtual std::size_t grids() const = 0;
    /// The list of the next grid's leaves, without blocks. Called once per grid.
    virtual StoredLeaves leaves() = 0;
    /// The next block of that grid's leaves; empty after the last one.
    virtual std::string block() = 0;
};

/// Writes the bytes of openvdb::io::File, apart from the random identity, in a fraction of the time: each leaf is
/// compressed once, by all threads. OpenVDB compresses each leaf twice, the second time by one thread.
///
/// The list of the leaves' sizes precedes the leaves and is compressed itself, so no place can be reserved for it: the
/// compressed leaves of one grid are held in memory, then written.
class VdbAssembly : public openvdb::io::Archive {
  public:
    /// @param compression flags of openvdb::io
    explicit VdbAssembly(std::uint32_t compression) { setCompression(compression); }

    /// @param stream seekable, and throws; OpenVDB does not check the state of its stream
    /// @param source of leaves; the nodes of those grids need no values
    void assemble(std::ostream& stream, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata,
                  LeafSource* source = nullptr) const;

    /// Store leaves of a grid as write() does. @param grid gives class, precision and background
    /// @tparam GridT a float or an int32 grid
    template<typename GridT>
    [[nodiscard]] StoredLeaves store(const GridT& grid,
                                     const std::vector<const typename GridT::TreeType::LeafNodeType*>& leaves) const;

  private:
    [[nodiscard]] std::uint32_t flagsOf(const openvdb::GridBase& grid) const;
    void writeGrid(openvdb::io::GridDescriptor& descriptor, const openvdb::GridBase::ConstPtr& grid, LeafSource* source,
                   std::ostream& stream) const;
};

} // namespace vdblic
