#pragma once

#include "vdblic/distributed/halo_exchange.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/flow_frame.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/lic/feedback_params.h"
#include "vdblic/lic/lic_kernel.h"
#include "vdblic/lic/scatter_params.h"
#include "vdblic/lic/scatter_stats.h"
#include "vdblic/noise/noise_field.h"

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace vdblic {

/// A step between two frames.
struct FlowStep {
    const FlowFrame& start;
    const FlowFrame& end;
    openvdb::Mat3d startToStep, endToStep; ///< stored values of the two frames → voxels per step
    double interval = 1;                   ///< seconds
    const HaloExchange* halo = nullptr;    ///< of the first frame's domain, if several ranks share the step
};

/// Seconds spent, in the parts of the paper's Table 2.
struct StageTimes {
    double load = 0;     ///< building the field from what was read
    double scatter = 0;  ///< advancing pathlines and depositing values
    double convolve = 0; ///< dividing sums by hits, and the mean along the flow
    double filter = 0;   ///< sharpening, contrast and noise

    StageTimes& operator+=(const StageTimes& other);
};

/// The texture of one step, with the work and the time spent on it.
struct FlowTextureStep {
    LeafValues<float> texture; ///< in [0, 1], on the domain of the step's first frame and in its halo
    ScatterStats stats;
    StageTimes times;
};

/// The textures of one field in memory, step by step: scatter, convolve, filter, feed forward (UFLIC's pipeline; Liu &
/// Moorhead 2004, Figure 1a), or line integral convolution of each frame on its own (Cabral & Leedom 1993).
///
/// Steps are computed in parallel; textures do not depend on the number of threads. One object serves one thread at a
/// time; distinct objects are independent.
class FlowTexture {
  public:
    /// @param steady if it has a value, every frame is convolved on its own with this kernel; of `scatter` only the
    /// life
    ///               span and the pathlines' parameters count then
    /// @throws ParameterError
    FlowTexture(const ScatterParams& scatter, const FeedbackParams& feedback, NoiseField noise,
                std::optional<LicKernel> steady = std::nullopt);
    ~FlowTexture();
    FlowTexture(FlowTexture&&) noexcept;
    FlowTexture& operator=(FlowTexture&&) noexcept;

    /// Compute the texture of the frame that a step starts from. Each step must start from the frame that the step
    /// before it ended at. Collective if several ranks share the step.
    /// @throws InputError if a voxel collected 2²³ hits or more
    FlowTextureStep advance(const FlowStep& step);

    /// The largest displacement of a pathline that goes on, along each axis [texture voxels per step]: no more than
    /// this can be added by pathlines to what the frames of the step to come ask for. @param interval seconds of that
    /// step
    [[nodiscard]] std::array<float, 3> largestSlope(double interval) const;

    /// The number of steps made.
    [[nodiscard]] std::uint64_t steps() const;

    /// Hand the state over to the ranks that own its voxels in another partition. Collective; at least one step must
    /// have been made.
    /// @param domain of the frame that the next step starts from, with this rank's own leaves in that partition
    void move(Exchange& exchange, const Partition& partition, std::shared_ptr<const Domain> domain);

    /// The state between two steps, on a part of the domain.
    struct Saved {
        openvdb::GridPtrVec grids; ///< of flow_state.h; none for steady LIC, which starts anew in every frame
        openvdb::CoordBBox box;    ///< of the part's leaves
    };
    /// In how many parts the state is saved: the more the larger it is, up to eight.
    [[nodiscard]] std::size_t parts() const;
    /// At least one step must have been made. @param part 0 to parts() − 1
    [[nodiscard]] Saved save(std::size_t part) const;

    /// Continue from the saved state of another FlowTexture with these parameters: its next steps and those of this one
    /// are the same to the bit.
    ///
    /// @param steps    made before the state was saved
    /// @param interval seconds of the last of them
    /// @param domain   of the frame that the next step starts from
    /// @param next     returns the parts one by one, of all ranks that saved, and nothing after the last; together they
    ///                 have at least the domain's own leaves
    /// @throws InputError, without the file's name, if the state does not fit these parameters and the domain
    void restore(std::uint64_t steps, double interval, std::shared_ptr<const Domain> domain,
                 const std::function<std::optional<VdbFile>()>& next);

  private:
    class Pipeline;
    std::unique_ptr<Pipeline> mPipeline;
};

} // namespace vdblic
