#include "vdblic/io/vdb_archive.h"

#include "vdblic/io/vdb_layout.h"

#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>

namespace vdblic {

void VdbArchive::readAnyHeader(std::istream& stream)
{
    constexpr std::size_t kFormat = sizeof(std::int64_t); // after the magic number
    std::string header(VdbLayout::kIdentityOffset + VdbLayout::kIdentityLength, '\0');
    const std::streampos begin = stream.tellg();
    stream.read(header.data(), std::streamsize(header.size()));
    std::uint32_t format = 0;
    std::memcpy(&format, header.data() + kFormat, sizeof format);
    if (format <= openvdb::OPENVDB_FILE_VERSION) {
        stream.seekg(begin);
        readHeader(stream);
        return;
    }
    std::memcpy(header.data() + kFormat, &openvdb::OPENVDB_FILE_VERSION, sizeof format);
    std::istringstream known(header);
    readHeader(known);
}

} // namespace vdblic
