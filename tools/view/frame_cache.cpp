#include "view/frame_cache.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

namespace vdblic::view {

FrameCache::Frame FrameCache::get(const std::string& key, const std::function<LoadedTexture()>& load)
{
    std::promise<Frame> promise;
    std::shared_future<Frame> found;
    {
        const std::lock_guard lock(mMutex);
        const auto entry =
            std::find_if(mEntries.begin(), mEntries.end(), [&](const Entry& other) { return other.key == key; });
        if (entry != mEntries.end()) {
            mEntries.splice(mEntries.begin(), mEntries, entry);
            found = entry->frame;
        } else {
            mEntries.push_front({key, promise.get_future().share()});
        }
    }
    if (found.valid()) return found.get();
    try {
        auto frame = std::make_shared<const LoadedTexture>(load());
        finish(key, frame->bytes());
        promise.set_value(frame);
        return frame;
    } catch (...) {
        forget(key);
        promise.set_exception(std::current_exception());
        throw;
    }
}

FrameCache::Frame FrameCache::find(const std::string& key)
{
    const std::lock_guard lock(mMutex);
    const auto entry =
        std::find_if(mEntries.begin(), mEntries.end(), [&](const Entry& other) { return other.key == key; });
    if (entry == mEntries.end() || entry->bytes == 0) return nullptr;
    mEntries.splice(mEntries.begin(), mEntries, entry);
    return entry->frame.get();
}

/// Note a frame's size, and let the least recently used ones go until the rest fits.
void FrameCache::finish(const std::string& key, double bytes)
{
    const std::lock_guard lock(mMutex);
    double sum = 0;
    for (auto entry = mEntries.begin(); entry != mEntries.end();) {
        if (entry->key == key) entry->bytes = bytes;
        sum += entry->bytes;
        const bool keep = entry->key == key || entry->bytes == 0 || sum <= mMost;
        if (!keep) sum -= entry->bytes;
        entry = keep ? std::next(entry) : mEntries.erase(entry);
    }
}

void FrameCache::forget(const std::string& key)
{
    const std::lock_guard lock(mMutex);
    mEntries.remove_if([&](const Entry& entry) { return entry.key == key; });
}

} // namespace vdblic::view
