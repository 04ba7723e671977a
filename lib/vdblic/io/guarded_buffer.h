#pragma once

#include "vdblic/io/vdb_layout.h"

#include <cstdint>
#include <fstream>
#include <vector>

namespace vdblic {

/// The bytes of a .vdb file for OpenVDB to read, and never more of them than it has room for.
///
/// A node's values come after the mask of its active ones, a byte that says which values are there, and 8 bytes with
/// their size. A size below 0 means values that are not compressed, and OpenVDB 10 reads as many bytes as it says,
/// whatever the size of its buffer (`bloscFromStream`, `unzipFromStream`).
class GuardedBuffer : public std::filebuf {
  public:
    /// Watch what is read from now on.
    /// @param stream that reads from here; OpenVDB keeps there how the current grid is stored. It must outlive this
    void guard(std::istream& stream, const VdbLayout& layout);

  protected:
    /// @throws InputError with the reason alone
    std::streamsize xsgetn(char* bytes, std::streamsize count) override;

  private:
    void note(const char* bytes, std::streamsize count);
    [[nodiscard]] std::int64_t room();

    std::istream* mStream = nullptr;
    std::vector<VdbLayout::Grid> mGrids;
    std::int64_t mUncompressed = 0;        // the bytes that the last thing read says will follow
    std::int64_t mValues = 0, mActive = 0; // of the current node
    bool mAfterMask = false, mBeforeSelection = false;
};

} // namespace vdblic
