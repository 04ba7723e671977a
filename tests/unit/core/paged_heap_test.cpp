#include "vdblic/core/paged_heap.h"

#include "temporary_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <thread>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

class PagedHeapTest : public testing::Test {
  protected:
    TemporaryFolder mFolder;
    ScratchFile mFile{mFolder.path(), false};
    PagedHeap mHeap{mFile};
};

/// An object that knows what it holds.
struct Marked {
    unsigned char* memory;
    std::size_t size;
    unsigned char mark;

    [[nodiscard]] bool isIntact() const
    {
        for (std::size_t i = 0; i < size; ++i) {
            if (memory[i] != mark) return false;
        }
        return true;
    }
};

/// Allocate and free at random; objects keep their contents though they leave the memory meanwhile.
void useAtRandom(PagedHeap& heap, std::uint32_t seed)
{
    std::mt19937 random(seed);
    std::vector<Marked> objects;
    for (int turn = 0; turn < 4000; ++turn) {
        if (objects.size() < 300 || random() % 2 == 0) {
            const std::size_t size = turn % 400 == 0 ? random() % (3 * PagedHeap::kRun) + 1 : random() % 9000 + 1;
            auto* const memory = static_cast<unsigned char*>(heap.allocate(size));
            ASSERT_NE(memory, nullptr);
            ASSERT_TRUE(heap.owns(memory) && heap.owns(memory + size - 1));
            ASSERT_EQ(reinterpret_cast<std::uintptr_t>(memory) % alignof(std::max_align_t), 0u);
            objects.push_back({memory, size, static_cast<unsigned char>(random())});
            std::memset(memory, objects.back().mark, size);
        } else {
            std::swap(objects[random() % objects.size()], objects.back());
            ASSERT_TRUE(objects.back().isIntact());
            heap.release(objects.back().memory);
            objects.pop_back();
        }
        if (turn % 50 == 0) heap.letGo(random() % heap.runs(), 3);
    }
    for (const Marked& object : objects) {
        EXPECT_TRUE(object.isIntact());
        heap.release(object.memory);
    }
}

TEST_F(PagedHeapTest, ThreadsKeepTheirObjectsApart)
{
    std::vector<std::thread> threads;
    for (std::uint32_t thread = 0; thread < 4; ++thread)
        threads.emplace_back([&, thread] { useAtRandom(mHeap, thread); });
    for (std::thread& thread : threads)
        thread.join();
}

TEST_F(PagedHeapTest, UsesFreedPlacesAgain)
{
    std::vector<void*> objects;
    for (int round = 0; round < 5; ++round) {
        for (int i = 0; i < 100000; ++i)
            objects.push_back(mHeap.allocate(2048));
        EXPECT_EQ(mHeap.runs(), 196u); // of 512 objects
        for (void* const object : objects)
            mHeap.release(object);
        objects.clear();
    }
    void* const large = mHeap.allocate(100 * PagedHeap::kRun);
    EXPECT_EQ(mHeap.runs(), 196u);
    mHeap.release(large);
}

TEST_F(PagedHeapTest, KeepsObjectsOfASizeInTheOrderOfAllocation)
{
    const char* before = nullptr;
    for (int i = 0; i < 1000; ++i) {
        const char* const object = static_cast<char*>(mHeap.allocate(6144));
        EXPECT_GT(object, before);
        before = object;
    }
}

TEST_F(PagedHeapTest, TellsThatTheFileCannotGrow)
{
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    rlimit little = before;
    little.rlim_cur = 4 * PagedHeap::kRun;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
    int objects = 0;
    while (mHeap.allocate(PagedHeap::kRun))
        ++objects;
    EXPECT_EQ(mHeap.reserve(5 * PagedHeap::kRun), EFBIG);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_EQ(objects, 4);
    EXPECT_EQ(mHeap.problem(), EFBIG);
}

} // namespace
} // namespace vdblic
