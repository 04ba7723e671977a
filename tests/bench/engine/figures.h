#pragma once

#include "vdblic/methods/flow_texture.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace vdblic::bench {

/// The cost of a run of a method, and the quality of its textures.
struct Figures {
    double nanoseconds = 0, wallNanoseconds = 0; ///< processor and wall time per voxel and frame
    StageTimes times;                            ///< of all frames
    ScatterStats stats;
    double voxels = 0;                                        ///< of all frames
    std::vector<double> temporal, smoothed, along, deviation; ///< of each frame, see CoherenceFigures
};

/// Print the heading of a table of Figures.
void printHeading(const char* title);

/// Print a row of the table. @return the same as JSON
nlohmann::json printRow(const std::string& name, const Figures& figures);

} // namespace vdblic::bench
