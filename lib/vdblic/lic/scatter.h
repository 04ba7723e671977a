#pragma once

#include "vdblic/lic/particle_bins.h"
#include "vdblic/lic/pathline.h"

#include <cstdint>
#include <vector>

namespace vdblic {

enum class ScatterMethod { kAuflic, kUflic };

/// How values are scattered along pathlines.
struct ScatterParams {
    ScatterMethod method = ScatterMethod::kAuflic;
    int lifeSpan = 4;            ///< time steps over which a seed scatters its value
    float releaseWindow = 0.25f; ///< AUFLIC: the part of a step, from its start, in which a seed may be released
    /// AUFLIC: a pathline that is blocked ends at once, its values going to the one that began the step in the same
    /// voxel if there is one; and a new pathline starts with the values that one through its voxel would carry.
    /// Without, both are as in the paper: what a blocked pathline carries goes on to the end of its life span, and a
    /// new one carries nothing but its own seeds.
    bool history = true;
    PathlineParams pathline;

    void validate() const; ///< @throws ParameterError
};

/// What one step did; every figure is the same for any number of threads.
struct ScatterStats {
    std::size_t particles = 0;   ///< pathlines of earlier steps that went on
    std::size_t blocked = 0;     ///< pathlines of earlier steps that ended because their voxel had its seed
    std::size_t released = 0;    ///< new particles: pathlines advected from scratch
    std::size_t reused = 0;      ///< seeds released onto particles of earlier steps: pathline reuse
    std::size_t copied = 0;      ///< seeds released downstream on a pathline of this step: pathline copying
    std::size_t steps = 0;       ///< integration steps
    std::size_t deposits = 0;    ///< additions to the accumulator
    std::size_t hits = 0;        ///< values deposited, counted with their multiplicity
    std::size_t emptyVoxels = 0; ///< voxels that no value was deposited in

    ScatterStats& operator+=(const ScatterStats& other);
};

/// Values and their number, packed into one word so that one addition scatters both: the sum of the 16-bit texture
/// values in 40 bits, the number of hits in the lower 23. Words add like the pairs they stand for as long
/// as a voxel collects fewer than 2²³ hits a step; Scatter::step() checks that none collected more.
struct Hits {
    static constexpr int kCountBits = 23;
    static constexpr std::uint64_t kCountMask = (std::uint64_t(1) << kCountBits) - 1;
    /// What an accumulator holds where there is no voxel of the domain: the one negative word.
    static constexpr std::int64_t kOutside = std::numeric_limits<std::int64_t>::min();

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

/// What a step starts from at a voxel, packed into one word: the value that its seed takes up, and what a pathline
/// through the voxel is taken to carry already. Both 0 to 65535.
struct Input {
    static constexpr std::int32_t pack(std::uint32_t value, std::uint32_t history)
    {
        return std::int32_t(history << 16 | value);
    }
    static constexpr std::uint32_t value(std::int32_t word) { return std::uint32_t(word) & 65535; }
    static constexpr std::uint32_t history(std::int32_t word) { return std::uint32_t(word) >> 16; }
};

/// An accumulator for a step on a domain: no hits yet.
[[nodiscard]] LeafValues<std::int64_t> makeAccumulator(const Domain& domain);

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
    /// @param field       velocity over the step, on its domain, as prepare() leaves it; filled slab by slab meanwhile
    /// @param input       Input words of the step's start, on the field's domain
    /// @param accumulator of makeAccumulator(), on the same domain; receives Hits
    /// @param next        domain of the step to come; particles that are outside it then end
    /// @param slopeScale  duration of this step over that of the step before, which slopes were measured in
    /// @throws InputError if a voxel collected 2²³ hits or more
    ScatterStats step(VelocityField& field, const LeafValues<std::int32_t>& input,
                      const LeafValues<std::int64_t>& accumulator, const Domain& next, float slopeScale = 1);

    /// The particles that go on, by the tiles of the domain of the step to come.
    [[nodiscard]] const std::vector<ParticleBins>& particles() const { return mBins; }

    /// Go on where another Scatter was after `steps` steps. @param particles those that it had
    void restore(std::uint64_t steps, ParticleBins particles);

  private:
    ScatterParams mParams;
    std::uint64_t mStep = 0;
    std::vector<ParticleBins> mBins; // of the particles that go on, one for each thread that moved some
};

} // namespace vdblic
