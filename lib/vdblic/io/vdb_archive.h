#pragma once

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>

#include <istream>

namespace vdblic {

/// Hides the differences between the archives of OpenVDB's versions.
class VdbArchive : public openvdb::io::Archive {
  protected:
    /// Read the header of a file that readLayout() accepts. A format newer than OpenVDB's own is read as its
    /// own: newer ones only add grid types, and OpenVDB would print a warning among the results of a tool.
    void readAnyHeader(std::istream& stream);

    /// Read a descriptor. @return an empty grid of its type
    template<typename Descriptor>
    static openvdb::GridBase::Ptr readDescriptor(Descriptor& descriptor, std::istream& stream)
    {
        if constexpr (requires { descriptor.readStreamPos(stream); }) {
            descriptor.readHeader(stream);
            descriptor.readStreamPos(stream);
            openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(descriptor.gridType());
            grid->setSaveFloatAsHalf(descriptor.saveFloatAsHalf());
            return grid;
        } else {
            return descriptor.read(stream);
        }
    }
};

} // namespace vdblic
