#include "vdblic/lic/scatter_stats.h"

namespace vdblic {

ScatterStats& ScatterStats::operator+=(const ScatterStats& other)
{
    particles += other.particles;
    blocked += other.blocked;
    released += other.released;
    reused += other.reused;
    copied += other.copied;
    steps += other.steps;
    deposits += other.deposits;
    hits += other.hits;
    emptyVoxels += other.emptyVoxels;
    return *this;
}

} // namespace vdblic
