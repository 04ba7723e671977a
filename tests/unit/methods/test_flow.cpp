#include "methods/test_flow.h"
#include "vdblic/methods/registry.h"

#include <cmath>
#include <memory>

namespace vdblic::test {

std::vector<VelocityFrame> makeFrames(const openvdb::CoordBBox& box, int frames, const FlowFunction& flow)
{
    std::vector<VelocityFrame> result;
    for (int frame = 0; frame < frames; ++frame) {
        const auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3f(0));
        auto values = grid->getAccessor();
        for (auto voxel = box.begin(); voxel; ++voxel) {
            if (const auto velocity = flow(*voxel, frame)) values.setValue(*voxel, *velocity);
        }
        const auto domain = std::make_shared<Domain>(
            std::make_shared<openvdb::MaskTree>(grid->tree(), false, true, openvdb::TopologyCopy()));
        result.push_back({FrameDomain(domain), grid});
    }
    return result;
}

std::vector<VelocityFrame> refined(std::vector<VelocityFrame> frames, const Refinement& refinement)
{
    for (VelocityFrame& frame : frames) {
        const std::shared_ptr<const Domain> coarse = frame.domain.velocity;
        frame.domain = {std::make_shared<Domain>(refinement.refined(coarse->topology())), coarse, refinement};
    }
    return frames;
}

FlowStep stepFrom(const std::vector<VelocityFrame>& frames, std::size_t k)
{
    return {frames[k], frames[k + 1]};
}

std::vector<VelocityFrame> unsteadyFlowWithHole(int frames)
{
    const openvdb::CoordBBox box({-5, 3, -9}, {16, 21, 8});
    return makeFrames(box, frames, [](const openvdb::Coord& at, int frame) -> std::optional<openvdb::Vec3f> {
        const float x = float(at[0]) - 5, y = float(at[1]) - 12, z = float(at[2]);
        const auto t = float(frame);
        const float holeX = x + 3 - 0.5f * t;
        if (holeX * holeX + y * y < 9 && std::abs(z) < 5) return std::nullopt;
        const float turn = 0.2f + 0.05f * std::sin(0.7f * t);
        return openvdb::Vec3f(1.4f * std::cos(0.5f * t) - turn * y, turn * x + 0.3f * std::sin(0.4f * z + t),
                              0.9f * std::sin(0.3f * x - 0.6f * t) + 0.2f);
    });
}

std::vector<LeafValues<float>> streamedTextures(const std::vector<VelocityFrame>& frames, int steps,
                                                const TextureParams& scatter)
{
    const auto pipeline = makeFlowTexture({scatter}, {NoiseField(7)});
    std::vector<LeafValues<float>> textures;
    textures.reserve(std::size_t(steps));
    for (int k = 0; k < steps; ++k)
        textures.push_back(pipeline->advance(stepFrom(frames, std::size_t(k))).texture);
    return textures;
}

TextureMemory& memoryOf(FlowTexture& texture)
{
    return dynamic_cast<TextureMemory&>(texture);
}

} // namespace vdblic::test
