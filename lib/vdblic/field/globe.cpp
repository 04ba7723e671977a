#include "vdblic/field/globe.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/field/for_leaves.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>

namespace vdblic {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;

constexpr int kShellVoxels = 5, kMarginVoxels = 2; // of its thickness

/// Integers [first, last] that are the indices of a leaf along an axis, by their distance from 0.
struct Reach {
    std::int64_t nearest, farthest;

    explicit Reach(int first) : nearest(std::max({first, -(first + 7), 0})), farthest(std::max(-first, first + 7)) {}
};

/// The voxels whose squared distance from voxel 0 is within bounds.
openvdb::MaskTree::Ptr shellOf(double least, double most)
{
    using Leaf = openvdb::MaskTree::LeafNodeType;
    auto topology = std::make_shared<openvdb::MaskTree>();
    const int end = int(std::sqrt(most)) + 1, begin = -(end + 7) / 8 * 8;
    const auto within = [&](std::int64_t squared) { return double(squared) >= least && double(squared) <= most; };
    for (int x = begin; x < end; x += 8) {
        for (int y = begin; y < end; y += 8) {
            for (int z = begin; z < end; z += 8) {
                const Reach reaches[] = {Reach(x), Reach(y), Reach(z)};
                std::int64_t nearest = 0, farthest = 0;
                for (const Reach& reach : reaches) {
                    nearest += reach.nearest * reach.nearest;
                    farthest += reach.farthest * reach.farthest;
                }
                if (double(farthest) < least || double(nearest) > most) continue;
                auto leaf = std::make_unique<Leaf>(Coord(x, y, z), false);
                for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
                    const Coord voxel = leaf->offsetToGlobalCoord(i);
                    const std::int64_t u = voxel.x(), v = voxel.y(), w = voxel.z();
                    if (within(u * u + v * v + w * w)) leaf->setValueOn(i);
                }
                if (!leaf->isEmpty()) topology->addLeaf(leaf.release()); // takes ownership
            }
        }
    }
    return topology;
}

openvdb::FloatGrid::Ptr rimOf(const Domain& domain, const openvdb::math::Transform& transform, double top)
{
    LeafValues<float> depths(domain, 0.0F);
    forLeaves(domain.own(), [&](std::size_t leaf) {
        float* values = depths[leaf];
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const Coord index = domain.origin(leaf) + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            const double radius = transform.indexToWorld(index).length();
            values[voxel.pos()] = float(std::min(radius - kEarthRadius, top - radius));
        }
    });
    auto grid = openvdb::FloatGrid::create(depths.tree());
    grid->setName("rim");
    grid->setTransform(transform.copy());
    grid->insertMeta("unit", openvdb::StringMetadata("Mm"));
    return grid;
}

} // namespace

Vec3d rossbyWave(const Vec3d& position, double time)
{
    constexpr double kOmega = 7.848e-6, kAmplitude = kOmega;
    const double radius = position.length();
    if (!(radius > 0)) return Vec3d(0);
    // On the unit sphere cos⁴φ cos 4λ is the real part of (x + iy)⁴, and the velocity n × ∇ψ of any continuation of ψ.
    const Vec3d n = position / radius;
    const std::complex<double> east(n.x(), n.y()), turn = std::polar(1.0, -4 * kRossbyRate * time);
    const std::complex<double> slope = 4.0 * turn * east * east * east;
    const double wave = (turn * east * east * east * east).real();
    const Vec3d gradient(kAmplitude * n.z() * slope.real(), -kAmplitude * n.z() * slope.imag(),
                         kAmplitude * wave - kOmega);
    return position.cross(gradient);
}

double voxelsOfGlobe(double voxelSize)
{
    constexpr int kLayers = kShellVoxels + 2 * kMarginVoxels;
    const double middle = kEarthRadius / voxelSize + kShellVoxels / 2.0;
    return 4 * std::numbers::pi * middle * middle * kLayers;
}

void checkGlobe(double voxelSize)
{
    constexpr double kLeast = 0.002, kMost = 0.5;
    if (!(voxelSize >= kLeast && voxelSize <= kMost)) {
        throw ParameterError(
            fmt::format("voxel size {}: voxels of a globe are {} to {} times 1000 km", voxelSize, kLeast, kMost));
    }
}

Globe makeGlobe(double voxelSize)
{
    checkGlobe(voxelSize);
    const auto voxels = std::uint64_t(voxelsOfGlobe(voxelSize));
    checkVoxels(voxels, "", 1, voxels);
    const double margin = kMarginVoxels * voxelSize, top = kEarthRadius + kShellVoxels * voxelSize;
    const double least = (kEarthRadius - margin) / voxelSize, most = (top + margin) / voxelSize;
    const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
    Globe globe{.domain = std::make_shared<const Domain>(shellOf(least * least, most * most)), .rim = {}, .solid = {}};
    globe.rim = rimOf(*globe.domain, *transform, top);
    globe.solid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(float(kEarthRadius), openvdb::Vec3f(0),
                                                                           float(voxelSize));
    globe.solid->setTransform(transform);
    globe.solid->setName("solid");
    return globe;
}

openvdb::FloatGrid::Ptr speedOnEarth(const openvdb::Vec3SGrid& velocity, const Domain& domain)
{
    constexpr double kMetres = 1e6;
    LeafValues<float> speeds(domain, 0.0F);
    forLeaves(domain.own(), [&](std::size_t leaf) {
        const auto* const velocities = velocity.tree().probeConstLeaf(domain.origin(leaf));
        for (auto voxel = domain.mask(leaf).beginOn(); voxel; ++voxel) {
            const Coord index = domain.origin(leaf) + Domain::Leaf::offsetToLocalCoord(voxel.pos());
            const double radius = velocity.indexToWorld(index).length();
            const double speed = Vec3d(velocities->getValue(voxel.pos())).length();
            speeds[leaf][voxel.pos()] = float(radius > 0 ? speed * kEarthRadius / radius * kMetres : 0);
        }
    });
    auto grid = openvdb::FloatGrid::create(speeds.tree());
    grid->setName("speed");
    grid->setTransform(velocity.transform().copy());
    grid->insertMeta("unit", openvdb::StringMetadata("m/s"));
    return grid;
}

} // namespace vdblic
