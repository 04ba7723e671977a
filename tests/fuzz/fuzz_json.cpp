/// Any file as key frames of a camera (first byte 'k') or as a transfer function: refused with a message, or in order.
#include "vdblic/camera/camera_path.h"
#include "vdblic/core/errors.h"
#include "vdblic/look/transfer_file.h"

#include "memory_file.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace {

void require(bool condition)
{
    if (!condition) std::abort();
}

void readKeys(const std::filesystem::path& path)
{
    const vdblic::CameraKeys keys = vdblic::readCameraKeys(path);
    for (const double frame : {-1e12, 0.0, 7.5, 1e12}) // numbers as long as no slope is beyond the largest number
        (void)keys.applied({}, frame);
}

void readTransfer(const std::filesystem::path& path)
{
    vdblic::TransferParams params;
    vdblic::readTransferFile(path, params);
    params.validate();
    if (params.range) require((*params.range)[0] < (*params.range)[1]);
    for (const vdblic::OpacityPoint& point : params.opacity)
        require(point.position >= 0 && point.position <= 1 && point.opacity >= 0 && point.opacity <= 1);
    for (const vdblic::ColorPoint& point : params.colors)
        require(point.position >= 0 && point.position <= 1 && point.color.r >= 0 && point.color.b <= 1);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    if (size == 0) return 0;
    const vdblic::MemoryFile file(data + 1, size - 1);
    try {
        data[0] == 'k' ? readKeys(file.path()) : readTransfer(file.path());
    } catch (const vdblic::InputError&) {
    }
    return 0;
}
