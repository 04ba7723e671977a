/// Any bytes as a .vdb file's header: refused with a message, or accepted with parts that are in order and inside the
/// file.
#include "vdblic/core/errors.h"
#include "vdblic/io/checksum.h"
#include "vdblic/io/vdb_layout.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    std::istringstream stream(std::string(reinterpret_cast<const char*>(data), size));
    try {
        const vdblic::VdbLayout layout = vdblic::readLayout(stream, size);
        std::uint64_t offset = layout.headerEnd;
        for (const vdblic::VdbLayout::Grid& grid : layout.grids) {
            if (grid.begin != offset || grid.end < grid.begin || grid.end > size) std::abort();
            offset = grid.end;
        }
        if (vdblic::hasChecksums(layout)) vdblic::verifyChecksums(stream, layout, size);
    } catch (const vdblic::InputError&) {
    }
    return 0;
}
