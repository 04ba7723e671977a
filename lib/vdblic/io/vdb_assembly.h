#pragma once

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include <cstdint>
#include <iosfwd>

namespace vdblic {

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
    void write(std::ostream& stream, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const;

  private:
    void writeGrid(openvdb::io::GridDescriptor& descriptor, const openvdb::GridBase::ConstPtr& grid,
                   std::ostream& stream) const;
};

} // namespace vdblic
