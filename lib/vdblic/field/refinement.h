#pragma once

#include "vdblic/core/parameters.h"
#include "vdblic/field/period.h"
#include "vdblic/field/units.h"
#include "vdblic/field/velocities.h"

#include <openvdb/openvdb.h>

#include <array>
#include <optional>
#include <string_view>

namespace vdblic {

/// Interpolation between voxels: trilinear, or by cubic convolution.
enum class Interpolation { kLinear, kCubic };
template<>
inline constexpr auto kNames<Interpolation> = std::to_array<std::string_view>({"linear", "cubic"});

/// The number of texture voxels in a velocity voxel along each axis.
///
/// Texture index f lies at velocity index (f + ½)/N − ½ along each axis, so N³ texture voxels fill a velocity voxel
/// exactly: those of velocity voxel v are vN to vN + N − 1. The texture leaves over one velocity leaf are whole leaves,
/// N along each axis. With N = 1 both index spaces are the same.
struct Refinement {
    static constexpr int kMost = 16;

    std::array<int, 3> factors{1, 1, 1};
    Interpolation interpolation = Interpolation::kLinear; ///< of the velocity between its voxels
    bool isGiven = false; ///< whether the user gave the factors; if not, a method may choose others

    void validate() const; ///< @throws ParameterError if a factor is not 1 to kMost

    [[nodiscard]] bool isNone() const { return factors == std::array{1, 1, 1}; }
    [[nodiscard]] int voxels() const { return factors[0] * factors[1] * factors[2]; } ///< per velocity voxel

    /// Velocity index of a texture index: index · scale() + shift(), along an axis.
    [[nodiscard]] float scale(int axis) const { return 1 / float(factors[std::size_t(axis)]); }
    [[nodiscard]] float shift(int axis) const { return 0.5f * scale(axis) - 0.5f; }

    /// The same velocities in voxels of the texture.
    template<Per kTime>
    [[nodiscard]] FromStored<Space::kTexture, kTime> toTexture(const FromStored<Space::kVelocity, kTime>& unit) const
    {
        return {toTexture() * unit.matrix};
    }
    template<Per kTime>
    [[nodiscard]] Velocities<Space::kTexture, kTime>
    toTexture(const Velocities<Space::kVelocity, kTime>& velocities) const
    {
        return {velocities.stored, toTexture(velocities.unit), velocities.period};
    }

    /// The voxel of the velocity that a texture voxel lies in.
    [[nodiscard]] Voxel<Space::kVelocity> coarse(const Voxel<Space::kTexture>& voxel) const;

    /// The leaf of the velocity that a leaf of the texture lies in, along an axis. @param leaf coordinate, in leaves
    [[nodiscard]] int coarseLeaf(int leaf, int axis) const;

    /// The texture's transform. @param velocity transform of the velocity
    [[nodiscard]] openvdb::math::Transform::Ptr refined(const openvdb::math::Transform& velocity) const;

    /// The refinement whose refined() transform of the velocity is the texture's, if there is one.
    [[nodiscard]] static std::optional<Refinement> between(const openvdb::math::Transform& velocity,
                                                           const openvdb::math::Transform& texture);

    /// A period of the velocity in voxels of the texture.
    [[nodiscard]] Period refined(const Period& velocity) const;

    /// The texture voxels in active voxels of the velocity; tiles are expanded.
    /// Computed in parallel. @param ranks that share the voxels. @throws InputError if they exceed the memory
    [[nodiscard]] openvdb::MaskTree::Ptr refined(const openvdb::MaskTree& velocity, int ranks = 1) const;

    /// The voxels of `velocity` that have at least one active texture voxel. Computed in parallel.
    [[nodiscard]] openvdb::MaskTree::Ptr coarsened(const openvdb::MaskTree& texture,
                                                   const openvdb::MaskTree& velocity) const;

    [[nodiscard]] bool operator==(const Refinement& other) const
    {
        return factors == other.factors && interpolation == other.interpolation;
    }

  private:
    [[nodiscard]] openvdb::Mat3d toTexture() const; // voxels of the velocity → voxels of the texture, for vectors
};

/// The parameter `refine`: one factor, or one for each axis. @param text what it refines
[[nodiscard]] Parameter refineParameter(std::string_view text, Refinement& refinement);

} // namespace vdblic
