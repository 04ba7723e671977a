#include "vdblic/lic/frame_writer.h"

#include "vdblic/core/stopwatch.h"

#include <utility>

namespace vdblic {

void FrameWriter::write(std::filesystem::path path, openvdb::GridCPtrVec grids, const openvdb::MetaMap& metadata,
                        std::vector<StoredLeaves> stored)
{
    const std::optional<std::filesystem::path> before = finishFile();
    mPath = std::move(path);
    mPending = std::async(std::launch::async,
                          [this, grids = std::move(grids), metadata, stored = std::move(stored)]() mutable {
                              Stopwatch watch;
                              writeStoredVdb(mPath, grids, metadata, mCompression, std::move(stored));
                              return watch.lap();
                          });
    if (before) report(*before);
}

void FrameWriter::finish()
{
    if (const auto path = finishFile()) report(*path);
}

void FrameWriter::finishWriting()
{
    const auto path = finishFile();
    try {
        if (path) report(*path);
    } catch (...) { // nobody reads the reports
    }
}

/// @return the file that is now finished, if one was being written
std::optional<std::filesystem::path> FrameWriter::finishFile()
{
    if (!mPending.valid()) return std::nullopt;
    mSeconds.push_back(mPending.get());
    ++mDone;
    return mPath;
}

void FrameWriter::report(const std::filesystem::path& path)
{
    mReporter.finished(path);
    mReporter.progress(mDone, mTotal);
}

void FrameWriter::pass(const std::filesystem::path& path)
{
    ++mDone;
    mReporter.finished(path);
}

} // namespace vdblic
