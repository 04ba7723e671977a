#include "vdblic/flow/velocity_sequence.h"

#include "temporary_folder.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/reporter.h"
#include "vdblic/io/vdb_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <cstddef>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// Frames 1, 2, … of velocities on boxes of 10 × 10 voxels and these lengths, and of masks that leave out as many
/// voxels along them as the frame's number.
class VelocitySequenceFrames : public testing::Test {
  protected:
    void write(const std::vector<int>& lengths)
    {
        openvdb::initialize();
        for (int i = 0; i < int(lengths.size()); ++i) {
            const openvdb::CoordBBox box({0, 0, 0}, {lengths[std::size_t(i)] - 1, 9, 9});
            const auto velocity = openvdb::Vec3SGrid::create();
            velocity->setName("velocity");
            velocity->denseFill(box, openvdb::Vec3f(float(i + 1), 0, 0));
            writeVdb(mFolder / fmt::format("v.{:04d}.vdb", i + 1), {velocity}, {});
            const auto mask = openvdb::MaskGrid::create();
            mask->denseFill({{i + 1, 0, 0}, box.max()}, true);
            writeVdb(mFolder / fmt::format("m.{:04d}.vdb", i + 1), {mask}, {});
        }
    }

    std::vector<VelocityFrame> read(bool masked)
    {
        VelocitySequenceParams params;
        params.input.pattern = (mFolder / "v.%04d.vdb").string();
        params.domain.refinement.factors = {2, 2, 2};
        if (masked) params.domain.mask = (mFolder / "m.%04d.vdb").string();
        std::istringstream noPaths;
        Reporter silent;
        OneProcess alone;
        std::size_t total = 0;
        VelocitySequence sequence(params, openSequence(params.input, noPaths, total), silent, alone);
        std::vector<VelocityFrame> frames;
        while (std::optional<VelocityFrame> frame = sequence.next())
            frames.push_back(std::move(*frame));
        return frames;
    }

  private:
    TemporaryFolder mFolder;
};

TEST_F(VelocitySequenceFrames, WithTheSameVoxelsShareADomain)
{
    write({12, 12, 20, 12});
    const std::vector<VelocityFrame> frames = read(false);
    ASSERT_EQ(frames.size(), 4u);
    EXPECT_EQ(frames[1].domain.texture, frames[0].domain.texture);
    EXPECT_EQ(frames[1].domain.velocity, frames[0].domain.velocity);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const std::size_t voxels = i == 2 ? 2000 : 1200;
        EXPECT_EQ(frames[i].domain.texture->voxelCount(), 8 * voxels) << i;
        EXPECT_EQ(frames[i].domain.velocity->voxelCount(), voxels) << i;
        EXPECT_EQ(frames[i].values->tree().getValue({3, 3, 3})[0], float(i + 1));
    }
}

TEST_F(VelocitySequenceFrames, HaveTheMaskOfTheirOwnNumber)
{
    write({12, 12, 12});
    const std::vector<VelocityFrame> frames = read(true);
    ASSERT_EQ(frames.size(), 3u);
    for (std::size_t i = 0; i < frames.size(); ++i)
        EXPECT_EQ(frames[i].domain.texture->voxelCount(), 8 * 100 * (12 - (i + 1))) << i;
}

} // namespace
} // namespace vdblic
