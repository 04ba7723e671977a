#include "vdblic/run/frame_writer.h"

#include "vdblic/core/message.h"
#include "vdblic/core/stopwatch.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace vdblic {

FrameWriter::FrameWriter(Reporter& reporter, Exchange& exchange, std::size_t total, VdbCompression compression,
                         int writers)
    : mReporter(reporter), mExchange(exchange), mTotal(total), mCompression(compression),
      mWriters(std::size_t(std::min(writers, exchange.size())))
{
}

FrameWriter::~FrameWriter()
{
    giveUp();
}

void FrameWriter::write(std::filesystem::path path, TextureFile file, std::vector<OwnLeaves> own)
{
    if (isMineNext()) mFile = std::move(file);
    mWaiting.push_back({std::move(path), std::move(own)});
    if (mWaiting.size() == mWriters) report(begin());
}

void FrameWriter::finish()
{
    report(begin());
    report(finishBegun());
}

void FrameWriter::finishWriting()
{
    const auto tryToReport = [this](const Paths& paths) {
        try {
            report(paths);
        } catch (...) { // the reports have no reader any more
        }
    };
    const auto waiting = double(mWaiting.size());
    std::array<double, 2> most = {waiting, -waiting};
    mExchange.max(most);
    if (most[0] != -most[1]) mWaiting.clear();
    tryToReport(begin());
    tryToReport(finishBegun());
}

/// Start to write the waiting files, after the previous ones. @return the files that are now finished
FrameWriter::Paths FrameWriter::begin()
{
    Paths finished = finishBegun();
    if (mWaiting.empty()) return finished;
    const auto rank = std::size_t(mExchange.rank());
    if (rank < mWaiting.size()) {
        mStream.emplace(mFile.computed);
        // If no thread can start, a single process writes when it waits for the file. Several ranks each need a thread.
        const auto how = mExchange.isAlone() ? std::launch::async | std::launch::deferred : std::launch::async;
        const auto write = [this, path = mWaiting[rank].path, held = std::make_shared<TextureFile>(std::move(mFile))] {
            const TextureFile file = std::move(*held); // freed when written; `held` lives as long as mPending
            Stopwatch watch;
            try {
                writeStoredVdb(path, file.grids, file.metadata, mCompression, &*mStream);
            } catch (...) {
                mStream->giveUp();
                throw;
            }
            return watch.lap();
        };
        mPending = std::async(how, write); // not moved: lost if a thread fails to start
    }
    deliverWaiting();
    for (Waiting& file : mWaiting)
        mBegun.push_back(std::move(file.path));
    mWaiting.clear();
    return finished;
}

void FrameWriter::deliverWaiting()
{
    const std::uint64_t before = mExchange.sent();
    try {
        for (std::size_t grid = 0; grid < mWaiting.front().own.size(); ++grid) {
            std::vector<OwnLeaves> leaves;
            for (Waiting& file : mWaiting)
                leaves.push_back(std::move(file.own[grid]));
            deliver(mExchange, std::move(leaves), mPending.valid() ? &*mStream : nullptr);
        }
    } catch (...) { // at all ranks
        mWaiting.clear();
        giveUp();
        throw;
    }
    mSent += mExchange.sent() - before;
}

/// Wait until the files being written are finished. @return their paths
FrameWriter::Paths FrameWriter::finishBegun()
{
    Paths paths = std::exchange(mBegun, {});
    if (paths.empty()) return paths;
    Exchange::Bytes seconds;
    if (mPending.valid()) put(seconds, mPending.get());
    for (const Exchange::Bytes& message : mExchange.gather(std::move(seconds))) {
        if (!message.empty()) mSeconds.push_back(MessageReader(message).get<double>());
    }
    mDone += paths.size();
    return paths;
}

/// End the writing thread if it waits for leaves that will not come.
void FrameWriter::giveUp()
{
    if (mStream) mStream->giveUp();
    if (mPending.valid()) mPending.wait();
    mPending = {};
}

void FrameWriter::report(const Paths& paths)
{
    std::size_t done = mDone - paths.size();
    for (const std::filesystem::path& path : paths) {
        mReporter.finished(path);
        mReporter.progress(++done, mTotal);
    }
}

void FrameWriter::pass(const std::filesystem::path& path)
{
    ++mDone;
    mReporter.finished(path);
}

} // namespace vdblic
