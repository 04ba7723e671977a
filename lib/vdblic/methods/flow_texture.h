#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_owners.h"
#include "vdblic/field/refinement.h"
#include "vdblic/field/units.h"
#include "vdblic/flow/flow_step.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/scatter_stats.h"
#include "vdblic/lic/stage_clock.h"
#include "vdblic/lines/lines.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace vdblic {

/// The texture of a step, with the work and time spent on it.
struct TextureFrame {
    TextureFrame() = default;
    /// No values.
    explicit TextureFrame(const FlowStep& step)
        : frame(step.start), substep(step.substep), time(step.time), interval(step.interval),
          domain(frame.domain.texture), refinement(frame.domain.refinement)
    {
    }

    VelocityFrame frame;       ///< the step's first frame
    int substep = 0;           ///< number of the step, counted from the frame on disk
    double time = 0;           ///< seconds
    double interval = 0;       ///< seconds between the frames on disk around it
    LeafValues<float> texture; ///< in [0, 1], on `domain` and in its halo; no tree if the step is not shown
    ScatterStats stats;
    StageTimes times;
    std::shared_ptr<const Domain> domain{}; ///< of the first frame; of a sparse texture its non-empty leaves
    Refinement refinement{};                ///< texture voxels for each velocity voxel
    openvdb::MetaMap metadata{};            ///< choices of the method, for the file's metadata
    LeafValues<float> source{};             ///< of streaks with sources: their numbers; else no tree
    LeafValues<std::int32_t> hits{};        ///< if requested: the values received by own voxels; else no tree
    std::optional<Lines> lines{};           ///< streaks as lines, without scalars, in place of `texture`

    [[nodiscard]] openvdb::math::Transform::Ptr transform() const ///< of the texture
    {
        return refinement.refined(frame.values->transform());
    }
};

/// Computes the textures of a flow, step by step.
///
/// Steps are computed in parallel; textures do not depend on the number of threads. One object serves one thread at a
/// time; distinct objects are independent. A method with a state between steps is a TextureMemory too; if the state
/// lies on the domain's leaves, also a LeafState.
class FlowTexture {
  public:
    virtual ~FlowTexture() = default;

    /// Compute the texture of a step's first frame. Each step must start from the frame at which the previous one
    /// ended. Collective if several ranks share the step.
    /// @throws InputError if a voxel collected 2²³ hits or more
    [[nodiscard]] virtual TextureFrame advance(const FlowStep& step) = 0;

    /// The farthest distance of a path in the next step.
    /// @param fastest of the flow  @param seconds of the step
    [[nodiscard]] virtual Lengths<Space::kTexture> farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                                double seconds) const = 0;
};

/// A method's state between steps, as stored in checkpoints.
class TextureMemory {
  public:
    virtual ~TextureMemory() = default;

    /// The state between two steps, on a part of the domain.
    struct Saved {
        openvdb::GridPtrVec grids;
        openvdb::CoordBBox box; ///< of the part's leaves
    };
    /// The number of parts in which the state is saved.
    [[nodiscard]] virtual std::size_t parts() const = 0;
    /// Requires at least one step. @param part 0 to parts() − 1
    [[nodiscard]] virtual Saved save(std::size_t part) const = 0;

    /// Continue from the saved state of another object with the same parameters: the next steps of both are equal to
    /// the bit.
    ///
    /// @param steps    made before the state was saved
    /// @param seconds  of the last of them
    /// @param domain   of the frame that the next step starts from
    /// @param next     returns the parts one by one, of all saving ranks, then nothing; together they have at least the
    /// domain's own leaves
    /// @throws InputError, without the file's name, if the state does not fit these parameters and the domain
    virtual void restore(std::uint64_t steps, double seconds, std::shared_ptr<const Domain> domain,
                         const std::function<std::optional<VdbFile>()>& next) = 0;
};

/// A state on the leaves of the domain; each rank holds the state of its own leaves.
class LeafState {
  public:
    virtual ~LeafState() = default;

    /// Hand the state over to the owners of its leaves in another partition. Collective; requires at least one step.
    /// @param domain of the frame from which the next step starts. Its own leaves are this rank's in that partition,
    /// its local ones those and the former own ones
    virtual void handOver(const LeafOwners& owners, std::shared_ptr<const Domain> domain) = 0;
};

/// Textures that choose their voxels by the flow of the first frame.
class AdaptiveTexture {
  public:
    virtual ~AdaptiveTexture() = default;

    /// Choose the voxels, before the first step. Not for a restored texture: TextureMemory::restore() sets its voxels.
    /// @param velocity     voxels of the first frame's velocity
    /// @param displacement of the flow's faster half in a frame [voxels of the velocity]
    /// @return the choices, as a text. @throws ParameterError
    [[nodiscard]] virtual std::string choose(const Domain& velocity, double displacement) = 0;
};

} // namespace vdblic
