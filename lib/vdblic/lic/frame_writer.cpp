#include "vdblic/lic/frame_writer.h"

#include "vdblic/core/stopwatch.h"

#include <utility>

namespace vdblic {

void FrameWriter::write(std::filesystem::path path, openvdb::GridCPtrVec grids, const openvdb::MetaMap& metadata)
{
    finish();
    mPath = std::move(path);
    mPending = std::async(std::launch::async, [this, grids = std::move(grids), metadata] {
        Stopwatch watch;
        writeVdb(mPath, grids, metadata, mCompression);
        return watch.lap();
    });
}

void FrameWriter::finish()
{
    if (!mPending.valid()) return;
    mSeconds.push_back(mPending.get());
    ++mDone;
    mReporter.finished(mPath);
    mReporter.progress(mDone, mTotal);
}

void FrameWriter::pass(const std::filesystem::path& path)
{
    ++mDone;
    mReporter.finished(path);
}

} // namespace vdblic
