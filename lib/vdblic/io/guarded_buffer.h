#pragma once

#include "vdblic/io/vdb_layout.h"

#include <cstdint>
#include <fstream>
#include <vector>

namespace vdblic {

/// A stream buffer over a .vdb file that prevents OpenVDB 10 from overflowing its buffers.
///
/// A node's values follow the mask of its active voxels, a byte that says which values are stored, and their size in 8
/// bytes. A negative size means uncompressed values; OpenVDB 10 then reads that many bytes without comparing with the
/// size of its buffer (`bloscFromStream`, `unzipFromStream`), as later versions do.
class GuardedBuffer : public std::filebuf {
  public:
    /// Check all reads from now on.
    /// @param stream over this buffer; OpenVDB keeps the current grid's compression on it. Must outlive this
    void guard(std::istream& stream, const VdbLayout& layout);

  protected:
    /// @throws InputError with the reason, but not the file
    std::streamsize xsgetn(char* bytes, std::streamsize count) override;

  private:
    void note(const char* bytes, std::streamsize count);
    [[nodiscard]] std::int64_t allocated();

    std::istream* mStream = nullptr;
    std::vector<VdbLayout::Grid> mGrids;
    std::int64_t mUncompressed = 0;        // size of uncompressed values announced by the last read
    std::int64_t mValues = 0, mActive = 0; // of the current node
    bool mAfterMask = false, mBeforeSelection = false;
};

} // namespace vdblic
