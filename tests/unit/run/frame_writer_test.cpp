#include "vdblic/core/exchange.h"
#include "vdblic/run/frame_writer.h"

#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

namespace vdblic {
namespace {

// The next step needs the memory: a file must not wait for the one after it.
TEST(FrameWriter, FreesAFileOnceItIsWritten)
{
    const TemporaryFolder folder;
    Reporter silent;
    OneProcess alone;
    FrameWriter writer(silent, alone, 2, VdbCompression::kBlosc, 1);
    TextureFile file;
    file.grids.push_back(openvdb::FloatGrid::create(0.5f));
    const std::weak_ptr<const openvdb::GridBase> grid = file.grids.front();
    const std::filesystem::path path = folder / "texture.vdb";
    writer.write(path, std::move(file), {});
    using Clock = std::chrono::steady_clock;
    for (const auto end = Clock::now() + std::chrono::seconds(20); !grid.expired() && Clock::now() < end;)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_TRUE(grid.expired());
    EXPECT_TRUE(std::filesystem::exists(path));
    EXPECT_EQ(writer.done(), 0u); // reported with the next one
    writer.finish();
    EXPECT_EQ(writer.done(), 1u);
}

} // namespace
} // namespace vdblic
