#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/flow/velocity_frame.h"
#include "vdblic/flow/velocity_sequence_params.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// The sequence to inspect, and the interpretation of its velocity.
struct SequenceInfoParams {
    VelocitySequenceParams flow;     ///< to its observer, displacements are as seen; a mean velocity is each frame's
    bool values = false;             ///< read the voxels too, besides the headers
    std::optional<int> refine{};     ///< of the textures in the estimate; nothing: 1, or the streaks' default
    std::optional<double> spacing{}; ///< of streaks, in the estimate [velocity voxels]; nothing: their default

    void validate() const; ///< @throws ParameterError
};
/// All parameters but the sequence: a tool inspects several.
[[nodiscard]] Parameters parametersOf(SequenceInfoParams& params);

/// The range of a grid's values over all frames; of vectors' lengths.
struct ValueInfo {
    double low, high;            ///< of the finite values; low exceeds high if there are none
    std::uint64_t notFinite = 0; ///< voxels

    [[nodiscard]] bool isFinite() const { return low <= high; } ///< whether any value is finite
};

/// A grid over the frames of a sequence.
struct GridInfo {
    std::string name, type, gridClass;
    std::size_t files = 0; ///< files that hold it
    std::size_t ofName =
        1; ///< grids of the name in a file, at most; all that is told is of the first, which tools read
    std::uint64_t leastVoxels = 0, mostVoxels = 0; ///< active ones in a file, as its writer stored them
    std::uint64_t mostMemory = 0;                  ///< bytes of its tree in memory, the same
    openvdb::CoordBBox box{};                      ///< of the active voxels of all files, the same
    openvdb::math::Transform::Ptr transform{};     ///< in the first file
    bool transformChanges = false;
    std::optional<ValueInfo> values{};
};

/// Displacements in a step [voxels], over all frames.
struct MotionInfo {
    double largest = 0, mean = 0;
    double fasterHalf = 0;                 ///< see Displacements
    double rotation = 0;                   ///< rotationShare() of the frame in the middle
    std::int64_t frame = 0;                ///< of the largest
    std::vector<std::string> otherUnits{}; ///< "voxel/s: 3.2": units that suit its faster half
};

/// Defaults of streaks for the largest frame, and the cost of such a run.
struct StreaksInfo {
    std::array<float, 3> spacing{}; ///< [voxels of the velocity]
    std::array<int, 3> refine{};
    std::optional<float> tail{};            ///< [frames], from the values
    double memory = 0, seconds = 0;         ///< as in VelocityInfo, drawn as voxels
    double lineMemory = 0, lineSeconds = 0; ///< drawn as lines
};

/// Estimates of a method other than the default.
struct MethodCost {
    std::string_view method;
    double memory = 0, seconds = 0; ///< as in VelocityInfo
};

/// The sequence's velocity as vdblic_advect would understand it, and the cost of its texture.
struct VelocityInfo {
    std::string grid;                   ///< its name; of three scalars, their names
    std::vector<std::string> gridNames; ///< of the grids that hold it
    VelocityUnit unit = VelocityUnit::kWorldPerSecond;
    double scale = 1;
    double interval = 0;                   ///< seconds between frames
    std::string intervalSource;            ///< "by the files' times"
    std::string intervalFault;             ///< why the files' times or dt are unusable, if they are wrong
    std::uint64_t voxels = 0;              ///< in the largest frame
    double memory = 0, seconds = 0;        ///< estimates: bytes, and seconds of processor time
    std::vector<MethodCost> lookingBack{}; ///< the same for the methods that look back
    std::optional<MotionInfo> motion{};    ///< from the values
    std::optional<StreaksInfo> streaks{};
};

/// Content of a sequence and estimates, before any computation.
struct SequenceInfo {
    std::string pattern, creator;
    std::vector<std::int64_t> frames, missing; ///< on disk; in gaps between them, or requested but absent
    bool isFrozen = false;                     ///< one frame without neighbours: a steady flow
    std::uint64_t bytes = 0;
    std::size_t withChecksums = 0;
    std::vector<std::string> damaged; ///< why files cannot be read
    std::vector<GridInfo> grids;
    std::optional<VelocityInfo> velocity;
    std::vector<std::string> advice;
};

/// Inspect a sequence. Unreadable files are counted; they are no errors.
/// @throws ParameterError; InputError if there is no file; Stopped
[[nodiscard]] SequenceInfo inspectSequence(const SequenceInfoParams& params, const Reporter& reporter);

/// The report, in lines.
[[nodiscard]] std::vector<std::string> infoLines(const SequenceInfo& info);
/// The report of several sequences as JSON with two spaces of indentation.
[[nodiscard]] std::string toJson(const std::vector<SequenceInfo>& sequences);

} // namespace vdblic
