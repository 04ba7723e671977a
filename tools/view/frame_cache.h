#pragma once

#include "vdblic/render/view.h"

#include <cstddef>
#include <functional>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <string>

namespace vdblic::view {

/// Frames that were read, the most recently used ones, up to an amount of memory. Any number of threads may ask.
class FrameCache {
  public:
    using Frame = std::shared_ptr<const LoadedTexture>;

    /// @param bytes of all frames; a single frame may take more
    explicit FrameCache(double bytes) : mMost(bytes) {}

    /// The frame of a key, loaded if need be, once for all who ask meanwhile. @throws what `load` does
    [[nodiscard]] Frame get(const std::string& key, const std::function<LoadedTexture()>& load);

    /// The frame of a key if it is loaded; else null.
    [[nodiscard]] Frame find(const std::string& key);

    [[nodiscard]] double most() const { return mMost; }

  private:
    struct Entry {
        std::string key;
        std::shared_future<Frame> frame;
        double bytes = 0; // 0 while it is loaded
    };

    void finish(const std::string& key, double bytes);
    void forget(const std::string& key);

    const double mMost;
    std::mutex mMutex;
    std::list<Entry> mEntries; // the most recently used first
};

} // namespace vdblic::view
