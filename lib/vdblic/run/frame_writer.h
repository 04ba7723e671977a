#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/distributed/leaf_delivery.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/run/texture_file.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <future>
#include <optional>
#include <vector>

namespace vdblic {

/// Writes the files of a sequence while the next ones are computed, and reports finished ones.
///
/// Ranks that share the run write in turn: a file waits, as stored leaves at the ranks that computed them, until each
/// writer has one. All ranks call all functions with the same files. Not thread-safe.
class FrameWriter {
  public:
    /// @param total   number of files, 0 if unknown
    /// @param writers number of writing ranks, from rank 0 on; at least 1
    FrameWriter(Reporter& reporter, Exchange& exchange, std::size_t total, VdbCompression compression, int writers);
    ~FrameWriter();
    FrameWriter(const FrameWriter&) = delete;
    FrameWriter& operator=(const FrameWriter&) = delete;

    /// The rank that writes the next file.
    [[nodiscard]] int next() const { return int(mWaiting.size()); }
    [[nodiscard]] bool isMineNext() const { return next() == mExchange.rank(); }

    /// Write a file, after the previous ones are finished. Collective on the last writer's turn.
    /// @param file ignored where !isMineNext()
    /// @param own  this rank's leaves of the computed grids, by grid
    /// @throws OutputError of an earlier file; what the reporter throws, while the file is being written
    void write(std::filesystem::path path, TextureFile file, std::vector<OwnLeaves> own);

    /// Wait until all files are finished. Collective. @throws OutputError, and exceptions of the reporter
    void finish();
    /// The same after an error, even if the reporter throws. Skips files that not all ranks passed to write().
    /// @throws OutputError
    void finishWriting();

    /// Report a file written by an earlier run.
    void pass(const std::filesystem::path& path);

    /// Seconds to write each finished file; at rank 0.
    [[nodiscard]] const std::vector<double>& seconds() const { return mSeconds; }

    /// The number of files of the run, 0 if unknown.
    [[nodiscard]] std::size_t total() const { return mTotal; }

    /// The number of files that are complete on disk.
    [[nodiscard]] std::size_t done() const { return mDone; }

    /// Bytes of leaves that this rank sent to others.
    [[nodiscard]] std::uint64_t sent() const { return mSent; }

  private:
    using Paths = std::vector<std::filesystem::path>;

    struct Waiting {
        std::filesystem::path path;
        std::vector<OwnLeaves> own; // for each grid
    };

    Paths begin();
    void deliverWaiting();
    Paths finishBegun();
    void giveUp();
    void report(const Paths& paths);

    Reporter& mReporter;
    Exchange& mExchange;
    std::size_t mTotal, mDone = 0;
    VdbCompression mCompression;
    std::size_t mWriters;
    std::vector<Waiting> mWaiting; // one for each writer, from rank 0 on
    TextureFile mFile;             // this rank's file of these
    Paths mBegun;
    std::optional<LeafStream> mStream; // to the writing thread
    std::vector<double> mSeconds;
    std::uint64_t mSent = 0;
    std::future<double> mPending; // last member: its thread uses the others
};

} // namespace vdblic
