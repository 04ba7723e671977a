#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_owners.h"
#include "vdblic/field/slabs.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/scatter_stats.h"
#include "vdblic/lic/stage_clock.h"
#include "vdblic/methods/auflic/particle_bins.h"
#include "vdblic/methods/texture_params.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace vdblic {

/// Receives the hits of an own leaf after a step.
/// @param hits 512 Hits words, x slowest
using TakeHits = std::function<void(std::size_t leaf, const std::int64_t* hits)>;

class Accumulator;
struct ScatterScene;

/// The load of a method's particles, and the way of scattering it.
struct ScatterMethod {
    std::size_t (*words)(const TextureParams& params); ///< number per particle beside its Hits
    std::uint64_t weight;                              ///< how often the Hits count an unfaded value
    bool feedsMean; ///< whether the mean along the flow is fed forward (FeedbackParams::taps)
    /// Scatter every tile. The particles that continue replace the arriving ones.
    /// @param accumulator its leaves are open while paths can reach them
    /// @param fill        called with the leaves of each velocity slab, to fill the field's
    /// @param collect     called with the leaves of each slab that no path can reach any more
    ScatterStats (*scatterTiles)(const ScatterScene& scene, VelocityField& field, Accumulator& accumulator,
                                 const std::function<void(Slabs::Leaves)>& fill,
                                 const std::function<void(Slabs::Leaves)>& collect);
};
extern const ScatterMethod kScatterFading; ///< FadingValues: AUFLIC with history
extern const ScatterMethod kScatterWindow; ///< ValueWindow: AUFLIC as published
extern const ScatterMethod kScatterSingle; ///< SingleValue: UFLIC

/// The value scattering of UFLIC and AUFLIC in streaming form (docs/algorithm.md).
///
/// Instead of advecting each seed through its whole life span into a ring of time buckets, every live particle is
/// advanced by the current step and deposits the sum of its values. Tiles (TileScatter) run in parallel; inside a tile
/// the seeding controller is sequential and touches its own tile only. The result does not depend on the number of
/// threads.
///
/// Sources: Shen & Kao 1998 (UFLIC); Liu & Moorhead 2002, 2004 (AUFLIC).
class Scatter {
  public:
    /// @param params with a method that scatters. @throws ParameterError
    explicit Scatter(const TextureParams& params);

    /// Advance every particle by one time step and scatter its values, releasing seeds as the method does.
    ///
    /// @param field       velocity over the step, as prepare() leaves it; filled slab by slab here
    /// @param input       fixed-point (kNoiseMax) at the step's start, on the field's domain
    /// @param take        called for each own leaf, in any order and by several threads
    /// @param next        domain of the next step; particles outside it end
    /// @param slopeScale  duration of this step over that of the step before, in which slopes were measured
    /// @param owners      of the field's leaves: a rank scatters its own tiles, and receives the hits of its own voxels
    ///                    and the particles of its own tiles
    /// @param clock       of the stages: filling the field is `load`, `take` is `convolve`
    /// @throws InputError if a voxel collected 2²³ hits or more
    ScatterStats step(VelocityField& field, const LeafValues<std::int32_t>& input, const TakeHits& take,
                      const Domain& next, float slopeScale, const LeafOwners& owners, StageClock& clock);

    /// The continuing particles, by tile of the next step's domain.
    [[nodiscard]] const std::vector<ParticleBins>& particles() const { return mBins; }

    [[nodiscard]] const ScatterMethod& method() const { return *mParams.method->scatter; }

    /// Hand the particles over to the owners of their leaves. Collective.
    /// @param domain of the next step; its local leaves contain all particles
    void handOver(const LeafOwners& owners, const Domain& domain);

    /// Continue from the particles of another Scatter after `steps` steps.
    void restore(std::uint64_t steps, ParticleBins particles);

  private:
    TextureParams mParams;
    std::uint64_t mStep = 0;
    std::vector<ParticleBins> mBins; // continuing particles; one for each thread
};

} // namespace vdblic
