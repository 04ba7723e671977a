#include "vdblic/render/texture_volume.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <array>

namespace vdblic {
namespace {

float fullFloat(HalfFloat x)
{
    return __builtin_bit_cast(float, std::uint32_t(x) << 16);
}

/// A symmetric matrix, xx yy zz xy xz yz.
using Symmetric = std::array<float, 6>;

/// The matrix over its trace; of no direction if that is 0.
Symmetric ofTraceOne(Symmetric m)
{
    const float trace = m[0] + m[1] + m[2];
    if (!(trace > 0)) return {1 / 3.0f, 1 / 3.0f, 1 / 3.0f, 0, 0, 0};
    for (float& value : m)
        value /= trace;
    return m;
}

Symmetric adjugate(const Symmetric& m)
{
    const auto [xx, yy, zz, xy, xz, yz] = m;
    return {yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy,
            xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - yz * xx};
}

Symmetric squared(const Symmetric& m)
{
    const auto [xx, yy, zz, xy, xz, yz] = m;
    return {xx * xx + xy * xy + xz * xz, xy * xy + yy * yy + yz * yz, xz * xz + yz * yz + zz * zz,
            xx * xy + xy * yy + xz * yz, xx * xz + xy * yz + xz * zz, xy * xz + yy * yz + yz * zz};
}

/// The projector on the direction a texture changes least in, from the mean of g·gᵀ over its gradients g nearby.
///
/// The adjugate has that direction as its strongest one; squaring it makes it all but the only one. Where no direction
/// stands out the result stays undecided, which lights a sample evenly.
Symmetric lineProjector(const Symmetric& structure)
{
    Symmetric m = ofTraceOne(adjugate(ofTraceOne(structure)));
    for (int i = 0; i < 2; ++i)
        m = ofTraceOne(squared(m));
    return m;
}

/// The structure tensor of a brick, smoothed by 1 2 1 along each axis: right for the leaf's own voxels.
struct StructureBlock {
    float values[6][kBrickSize];

    void fill(const GradientRecord* gradients)
    {
        for (int i = 0; i < kBrickSize; ++i) {
            const float x = fullFloat(gradients[i].values[0]), y = fullFloat(gradients[i].values[1]),
                        z = fullFloat(gradients[i].values[2]);
            const float products[] = {x * x, y * y, z * z, x * y, x * z, y * z};
            for (int k = 0; k < 6; ++k)
                values[k][i] = products[k];
        }
        for (float* value : values) {
            for (const int stride : {1, kBrickDim, kBrickDim * kBrickDim})
                smooth(value, stride);
        }
    }

    /// In place: what is overwritten is kept for the next one, a stride on.
    static void smooth(float* value, int stride)
    {
        float before[kBrickDim * kBrickDim];
        std::copy(value, value + stride, before);
        for (int i = stride; i < kBrickSize - stride; ++i) {
            float& previous = before[i % stride];
            const float here = value[i];
            value[i] = previous + 2 * here + value[i + stride];
            previous = here;
        }
    }
};

} // namespace

void TextureVolume::addLines()
{
    const std::size_t leaves = domain().leafCount();
    mLines.reset(new LineRecord[leaves * kBrickSize]);
    using Range = tbb::blocked_range<std::size_t>;
    tbb::parallel_for(Range(0, leaves), [&](const Range& some) {
        const auto block = std::make_unique<StructureBlock>();
        for (std::size_t leaf = some.begin(); leaf < some.end(); ++leaf) {
            block->fill(mGradients.get() + leaf * kBrickSize);
            for (int offset = 0; offset < Domain::kLeafVoxels; ++offset) {
                const int i = brickIndex(offset >> 6, offset >> 3 & 7, offset & 7);
                Symmetric structure;
                for (std::size_t k = 0; k < 6; ++k)
                    structure[k] = block->values[k][i];
                const Symmetric line = lineProjector(structure);
                LineRecord& record = mLines[leaf * kBrickSize + std::size_t(i)];
                record = {};
                for (std::size_t k = 0; k < 6; ++k)
                    record.values[k] = halfFloat(line[k]);
            }
        }
    });
    // The voxels around a leaf are its neighbours' own, or, where it has none, its last ones.
    tbb::parallel_for(std::size_t(0), leaves, [&](std::size_t leaf) {
        const openvdb::Coord origin = domain().origin(leaf);
        for (int i = 0; i < kBrickSize; ++i) {
            const int place[] = {i / (kBrickDim * kBrickDim) - 1, i / kBrickDim % kBrickDim - 1, i % kBrickDim - 1};
            if (std::all_of(place, place + 3, [](int p) { return p >= 0 && p < 8; })) continue;
            const Int4 voxel{origin[0] + place[0], origin[1] + place[1], origin[2] + place[2]};
            const int neighbour = domain().findLeaf(voxel);
            const auto inside = [&](int axis) {
                return neighbour >= 0 ? voxel[axis] & 7 : std::clamp(place[axis], 0, 7);
            };
            mLines[leaf * kBrickSize + std::size_t(i)] =
                mLines[(neighbour >= 0 ? std::size_t(neighbour) : leaf) * kBrickSize +
                       std::size_t(brickIndex(inside(0), inside(1), inside(2)))];
        }
    });
}

} // namespace vdblic
