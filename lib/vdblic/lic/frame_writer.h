#pragma once

#include "vdblic/core/reporter.h"

#include <openvdb/openvdb.h>

#include <filesystem>
#include <future>
#include <vector>

namespace vdblic {

/// Writes one file of a sequence while the next is computed, and reports what is finished. Not thread-safe.
class FrameWriter {
  public:
    /// @param total number of files, 0 if it is not known
    FrameWriter(Reporter& reporter, std::size_t total) : mReporter(reporter), mTotal(total) {}

    /// Begin to write a file; the one before is finished first. @throws OutputError of the one before
    void write(std::filesystem::path path, openvdb::GridCPtrVec grids, openvdb::MetaMap metadata);

    /// Wait for the file that is being written. @throws OutputError
    void finish();

    /// Report a file that a run before has written.
    void pass(const std::filesystem::path& path);

    /// Seconds that each write() took, of those that are finished.
    [[nodiscard]] const std::vector<double>& seconds() const { return mSeconds; }

    /// The number of files that are complete on disk.
    [[nodiscard]] std::size_t done() const { return mDone; }

  private:
    Reporter& mReporter;
    std::size_t mTotal, mDone = 0;
    std::filesystem::path mPath;
    std::vector<double> mSeconds;
    std::future<double> mPending;
};

} // namespace vdblic
