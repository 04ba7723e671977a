#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdblic {

/// Polylines at one time. The points of a line are consecutive, from its tail to its head.
struct Lines {
    struct Line {
        std::int32_t id;          ///< the same in all frames; unique in a frame
        std::uint32_t begin, end; ///< its points: [begin, end)
        std::uint8_t source = 0;  ///< number of the source that its particle was last in; 0 for none
    };
    /// A quantity with a value at each point; NaN where the flow has none.
    struct Scalar {
        std::string name;
        std::vector<float> values;
    };

    std::vector<Line> lines;
    // One entry for each point:
    std::vector<openvdb::Vec3f> positions; ///< index space of the velocity, voxel centres at integers
    std::vector<float> radii;              ///< of the tube [world units]
    std::vector<float> opacities;          ///< 0 to 1; highest at the head
    std::vector<float> ages;               ///< time since the particle was there [frames]
    std::vector<Scalar> scalars;

    [[nodiscard]] std::size_t pointCount() const { return positions.size(); }
};

} // namespace vdblic
