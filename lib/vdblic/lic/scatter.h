#pragma once

#include "vdblic/distributed/halo_exchange.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/particle_bins.h"
#include "vdblic/lic/scatter_params.h"
#include "vdblic/lic/scatter_stats.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace vdblic {

/// Takes the hits of one of the own leaves after a step.
/// @param hits 512 Hits words, x slowest
using TakeHits = std::function<void(std::size_t leaf, const std::int64_t* hits)>;

/// The farthest that a path of a step leads from its start, along an axis [voxels]. @param slope the largest
/// displacement in a step: the Hermite curve swings beyond its ends by at most 4/27 of the slope at each.
[[nodiscard]] constexpr float longestPath(float slope)
{
    constexpr float kSwing = 1 + 2 * 4.0f / 27, kRounding = 1; // voxels
    return kSwing * slope + kRounding;
}

/// The value scattering of UFLIC and AUFLIC in streaming form (docs/algorithm.md).
///
/// Instead of advecting each seed through its whole life span into a ring of time buckets, every live particle is
/// advanced by the step being computed and deposits the sum of the values it carries. Tiles (TileScatter) are computed
/// in parallel; inside a tile the seeding controller is sequential and touches its own tile only. The result does not
/// depend on the number of threads.
///
/// Sources: Shen & Kao 1998 (UFLIC); Liu & Moorhead 2002, 2004 (AUFLIC).
class Scatter {
  public:
    explicit Scatter(const ScatterParams& params); ///< @throws ParameterError

    /// Carry every particle over one time step, releasing seeds as the method does.
    ///
    /// @param field       velocity over the step, as prepare() leaves it; filled slab by slab meanwhile
    /// @param input       fixed-point (kNoiseMax) at the step's start, on the field's domain
    /// @param take        called for each own leaf, in any order and by several threads
    /// @param next        domain of the step to come; particles outside it end
    /// @param slopeScale  duration of this step over that of the step before, in which slopes were measured
    /// @param halo        of the field's domain, if several ranks share the step: each scatters its own tiles, and gets
    ///                    its own voxels' hits and its own tiles' particles. Collective then.
    /// @throws InputError if a voxel collected 2²³ hits or more
    ScatterStats step(VelocityField& field, const LeafValues<std::int32_t>& input, const TakeHits& take,
                      const Domain& next, float slopeScale = 1, const HaloExchange* halo = nullptr);
    /// In `take`, during the last step, all threads at once.
    [[nodiscard]] double secondsToTake() const { return mSecondsToTake; }

    /// The particles that go on, by the tiles of the domain of the step to come.
    [[nodiscard]] const std::vector<ParticleBins>& particles() const { return mBins; }

    /// Hand the particles over to the ranks that own them in another partition. Collective.
    /// @param domain of the step to come: its own leaves are this rank's in that partition, its local ones include
    /// those
    ///               it had before
    void move(Exchange& exchange, const Partition& partition, const Domain& domain);

    /// Continue from the state of another Scatter after `steps` steps. @param particles those of the other
    void restore(std::uint64_t steps, ParticleBins particles);

  private:
    ScatterParams mParams;
    std::uint64_t mStep = 0;
    double mSecondsToTake = 0;
    std::vector<ParticleBins> mBins; // of the particles that go on, one for each thread that moved some
};

} // namespace vdblic
