#pragma once

#include "vdblic/lic/pathline.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace vdblic {

enum class ScatterMethod { kAuflic, kUflic };

/// How values are scattered along pathlines.
struct ScatterParams {
    ScatterMethod method = ScatterMethod::kAuflic;
    int lifeSpan = 4;            ///< time steps over which a seed scatters its value
    float releaseWindow = 0.25f; ///< AUFLIC: the part of a step, from its start, in which a seed may be released
    PathlineParams pathline;

    void validate() const; ///< @throws ParameterError
};

/// What one step did; every figure is the same for any number of threads.
struct ScatterStats {
    std::size_t particles = 0; ///< live at the start of the step, inside the domain
    std::size_t released = 0;  ///< new particles: pathlines advected from scratch
    std::size_t reused = 0;    ///< seeds released onto particles of earlier steps: pathline reuse
    std::size_t copied = 0;    ///< seeds released downstream on a pathline of this step: pathline copying
    std::size_t steps = 0;     ///< integration steps
    std::size_t deposits = 0;  ///< additions to the accumulator
    std::size_t hits = 0;      ///< values deposited, counted with their multiplicity

    ScatterStats& operator+=(const ScatterStats& other);
};

/// Values and their number, packed into one word so that one addition scatters both: the sum of the 16-bit texture
/// values in the upper 40 bits, the number of hits in the lower 24. Words add like the pairs they stand for as long
/// as a voxel collects fewer than 2²⁴ hits a step; Scatter::step() checks that none collected more.
struct Hits {
    static constexpr int kCountBits = 24;
    static constexpr std::uint64_t kCountMask = (std::uint64_t(1) << kCountBits) - 1;

    static constexpr std::uint64_t pack(std::uint64_t sum, std::uint64_t count) { return sum << kCountBits | count; }
    static constexpr std::uint64_t sum(std::uint64_t word) { return word >> kCountBits; }
    static constexpr std::uint64_t count(std::uint64_t word) { return word & kCountMask; }
};

/// The seeds released onto one particle in one scattering process: the sum of up to 255 16-bit values in the upper
/// 24 bits of the word, their number in the lower 8.
struct Generation {
    static constexpr std::uint32_t kMaxCount = 255;

    static constexpr std::uint32_t add(std::uint32_t word, std::uint32_t value) { return word + (value << 8 | 1); }
    static constexpr std::uint32_t count(std::uint32_t word) { return word & 255; }
    static constexpr std::uint64_t hits(std::uint32_t word) { return Hits::pack(word >> 8, word & 255); }
};

/// A pathline in the making: where it is now, and the values it carries.
struct Particle {
    static constexpr int kRankBits = 40; // of the id

    std::array<float, 3> position; ///< index space, voxel centres at integers
    std::array<float, 3> slope;    ///< velocity there, voxels per time step
    std::uint64_t alive;           ///< Hits of the values that are still within their life span
    std::uint64_t id; ///< step of release << kRankBits | rank of the release voxel in the domain's scan order
};

/// Particles and, `lifeSpan` words for each, the generations they carry (AUFLIC only).
struct ParticleStore {
    std::vector<Particle> particles;
    std::vector<std::uint32_t> generations; ///< slot s of a particle: scattering process k with k mod lifeSpan = s
};

/// The value scattering of UFLIC and AUFLIC in streaming form (docs/algorithm.md).
///
/// Instead of advecting each seed through its whole life span into a ring of time buckets, every live particle is
/// advanced by the one step that is being computed and deposits the sum of the values it carries. Tiles of one
/// leaf are computed in parallel; inside a tile the seeding controller is sequential, and it touches nothing but
/// its tile. The result does not depend on the number of threads.
///
/// Sources: Shen & Kao 1998 (UFLIC); Liu & Moorhead 2002, 2004 (AUFLIC).
class Scatter {
  public:
    explicit Scatter(const ScatterParams& params); ///< @throws ParameterError

    /// Carry every particle over one time step, releasing seeds as the method does.
    ///
    /// @param field       velocity over the step, on its domain
    /// @param input       texture values 0 to 65535 at the step's start, on the field's domain
    /// @param accumulator receives Hits, on the same domain; to be zero before
    /// @param slopeScale  duration of this step over that of the step before, which slopes were measured in
    /// @throws InputError if a voxel collected 2²⁴ hits or more
    ScatterStats step(const VelocityField& field, const LeafValues<std::int32_t>& input,
                      const LeafValues<std::int64_t>& accumulator, float slopeScale = 1);

  private:
    void sortIntoTiles(const Domain& domain, float slopeScale);

    ScatterParams mParams;
    std::uint64_t mStep = 0;
    std::vector<ParticleStore> mMoved; // by the last step, in any order
    ParticleStore mSorted;             // by tile, then by id
    std::vector<std::size_t> mTileBegin;
};

} // namespace vdblic
