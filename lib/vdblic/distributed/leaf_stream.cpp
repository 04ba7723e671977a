#include "vdblic/distributed/leaf_stream.h"

#include "vdblic/core/reporter.h"

#include <utility>

namespace vdblic {
namespace {

constexpr std::size_t kMostWaiting = std::size_t(256) << 20; // bytes

} // namespace

StoredLeaves LeafStream::leaves()
{
    return take();
}

std::string LeafStream::block()
{
    return std::move(take().blocks.front());
}

void LeafStream::begin(StoredLeaves leaves)
{
    push(std::move(leaves));
}

void LeafStream::give(std::string block)
{
    if (block.empty()) return;
    StoredLeaves item;
    item.blocks.push_back(std::move(block));
    push(std::move(item));
}

void LeafStream::end()
{
    StoredLeaves item;
    item.blocks.emplace_back();
    push(std::move(item));
}

void LeafStream::giveUp()
{
    const std::lock_guard lock(mMutex);
    mGivenUp = true;
    mChanged.notify_all();
}

void LeafStream::push(StoredLeaves item)
{
    std::unique_lock lock(mMutex);
    mChanged.wait(lock, [this] { return mGivenUp || mBytes <= kMostWaiting; });
    if (mGivenUp) return;
    for (const std::string& block : item.blocks)
        mBytes += block.size();
    mItems.push_back(std::move(item));
    mChanged.notify_all();
}

StoredLeaves LeafStream::take()
{
    std::unique_lock lock(mMutex);
    mChanged.wait(lock, [this] { return mGivenUp || !mItems.empty(); });
    if (mGivenUp) throw Stopped{};
    StoredLeaves item = std::move(mItems.front());
    mItems.pop_front();
    for (const std::string& block : item.blocks)
        mBytes -= block.size();
    mChanged.notify_all();
    return item;
}

} // namespace vdblic
