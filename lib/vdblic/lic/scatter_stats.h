#pragma once

#include <cstddef>

namespace vdblic {

/// Counters of one step; equal for any number of threads.
struct ScatterStats {
    std::size_t particles = 0;   ///< continued pathlines of earlier steps
    std::size_t blocked = 0;     ///< pathlines of earlier steps that ended in a voxel with a seed
    std::size_t released = 0;    ///< new particles: pathlines advected from scratch
    std::size_t reused = 0;      ///< seeds released onto particles of earlier steps: pathline reuse
    std::size_t copied = 0;      ///< seeds released downstream on a pathline of this step: pathline copying
    std::size_t steps = 0;       ///< integration steps
    std::size_t deposits = 0;    ///< additions to the accumulator
    std::size_t hits = 0;        ///< values deposited, counted with their multiplicity; faded ones for less
    std::size_t emptyVoxels = 0; ///< voxels without a deposit

    ScatterStats& operator+=(const ScatterStats& other);
};

} // namespace vdblic
