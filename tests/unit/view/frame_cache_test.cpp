#include "view/frame_cache.h"

#include "cast/test_scene.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace vdblic::view {
namespace {

LoadedTexture texture(int leaves = 1)
{
    const auto grid = boxGrid("density", boxOf(8 * leaves, 8, 8), scattered);
    return {
        .file = {1, "lic.vdb"}, .texture = grid, .color = grid, .opacity = grid, .volume = TextureVolume(*grid, *grid)};
}

const double kSize = texture().bytes();

class Caching : public testing::Test {
  protected:
    FrameCache::Frame get(const std::string& key, int leaves = 1)
    {
        return mCache.get(key, [&] {
            ++mLoads;
            return texture(leaves);
        });
    }
    /// Whether a frame was kept.
    bool has(const std::string& key)
    {
        const int before = mLoads;
        (void)get(key);
        return mLoads == before;
    }

    FrameCache mCache{2.5 * kSize};
    std::atomic<int> mLoads = 0;
};

TEST_F(Caching, AFrameIsLoadedOnce)
{
    const auto first = get("a");
    EXPECT_EQ(get("a"), first);
    EXPECT_NE(get("b"), first);
    EXPECT_EQ(mLoads, 2);
}

TEST_F(Caching, ThoseWhoAskMeanwhileGetTheSameFrame)
{
    constexpr int kThreads = 6;
    std::latch allHere(kThreads);
    std::vector<FrameCache::Frame> frames(kThreads);
    std::vector<std::thread> threads;
    for (auto& frame : frames) {
        threads.emplace_back([&] {
            allHere.arrive_and_wait();
            frame = get("a");
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(mLoads, 1);
    for (const auto& frame : frames)
        EXPECT_EQ(frame, frames.front());
}

TEST_F(Caching, TheLeastRecentlyUsedFrameGoes)
{
    const auto held = get("a");
    (void)get("b");
    EXPECT_TRUE(has("a")); // used after b
    (void)get("c");        // more than fits
    EXPECT_TRUE(has("a"));
    EXPECT_TRUE(has("c"));
    EXPECT_FALSE(has("b"));
    EXPECT_EQ(held->bytes(), kSize); // whoever has a frame keeps it
}

TEST_F(Caching, AFrameMayBeLargerThanTheCache)
{
    (void)get("a");
    const auto large = get("large", 4);
    EXPECT_GT(large->bytes(), mCache.most());
    EXPECT_TRUE(has("large"));
    EXPECT_FALSE(has("a"));
}

TEST_F(Caching, AFailureIsNotKept)
{
    const auto fail = [&] { return mCache.get("a", []() -> LoadedTexture { throw std::runtime_error("damaged"); }); };
    EXPECT_THROW((void)fail(), std::runtime_error);
    EXPECT_THROW((void)fail(), std::runtime_error);
    EXPECT_TRUE(get("a"));
    EXPECT_EQ(fail(), get("a"));
}

} // namespace
} // namespace vdblic::view
