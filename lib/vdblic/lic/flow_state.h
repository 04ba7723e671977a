#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/particle_bins.h"

#include <cstdint>
#include <vector>

namespace vdblic {

/// What one step hands to the next, as grids that other programs can open, and back to the bit.
///
/// `noise`: the noise-jittered texture that seeds take their values from; `texture`: what a pathline through a voxel is
/// taken to carry already. Both float, multiples of 1/65536 in [0, 1).
/// `particles`: points, with the attributes `slope` (velocity there, voxels per step), `id` (step of release << 40 |
/// rank of the release voxel) and `generations` (Generation words, by release step modulo the life span; for UFLIC a
/// single one). Points are stored as their distance from the centre of their voxel: no bit of a position is lost.

/// Input words of a step as `noise` and `texture`.
[[nodiscard]] openvdb::GridPtrVec inputGrids(const Domain& domain, const LeafValues<std::int32_t>& input);

/// @throws InputError, without the file's name, if the grids are missing or do not cover just the domain
[[nodiscard]] LeafValues<std::int32_t> readInput(const Domain& domain, const VdbFile& file);

/// @param domain the bins' tiles
[[nodiscard]] openvdb::GridBase::Ptr particleGrid(const Domain& domain, const std::vector<ParticleBins>& bins);

/// @param generations words that each particle carries; 0 for UFLIC
/// @throws InputError, without the file's name, if the grid is missing or does not fit the domain
[[nodiscard]] ParticleBins readParticles(const Domain& domain, const VdbFile& file, std::size_t generations);

} // namespace vdblic
