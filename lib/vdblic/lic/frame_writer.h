#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/io/vdb_assembly.h"
#include "vdblic/io/vdb_file.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <filesystem>
#include <future>
#include <optional>
#include <vector>

namespace vdblic {

/// Writes the files of a sequence, each while the next is computed, and reports those that are finished. Not
/// thread-safe.
class FrameWriter {
  public:
    /// @param total number of files, 0 if it is unknown
    FrameWriter(Reporter& reporter, std::size_t total, VdbCompression compression)
        : mReporter(reporter), mTotal(total), mCompression(compression)
    {
    }

    /// Begin to write a file, after the previous one is finished. @throws OutputError of the previous one; what the
    /// reporter throws, while the file is being written
    /// @param stored leaves of the first grids, as writeStoredVdb() takes them
    void write(std::filesystem::path path, openvdb::GridCPtrVec grids, const openvdb::MetaMap& metadata,
               std::vector<StoredLeaves> stored = {});

    /// Wait until the file being written is finished. @throws OutputError, what the reporter throws
    void finish();
    /// The same even if the reporter throws. @throws OutputError
    void finishWriting();

    /// Report a file that an earlier run has written.
    void pass(const std::filesystem::path& path);

    /// Seconds that each finished write() took.
    [[nodiscard]] const std::vector<double>& seconds() const { return mSeconds; }

    /// The number of files that there will be, 0 if it is unknown.
    [[nodiscard]] std::size_t total() const { return mTotal; }

    /// The number of files that are complete on disk.
    [[nodiscard]] std::size_t done() const { return mDone; }

  private:
    std::optional<std::filesystem::path> finishFile();
    void report(const std::filesystem::path& path);

    Reporter& mReporter;
    std::size_t mTotal, mDone = 0;
    VdbCompression mCompression;
    std::filesystem::path mPath;
    std::vector<double> mSeconds;
    std::future<double> mPending;
};

} // namespace vdblic
