#pragma once

#include "vdblic/compare/difference.h"
#include "vdblic/core/parameters.h"
#include "vdblic/core/reporter.h"

#include <openvdb/version.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {
class GridBase;
}
} // namespace openvdb

namespace vdblic {

struct VdbFile;

/// The names of metadata that describe how and when a file was made, not its content.
[[nodiscard]] std::vector<std::string> creationMetadata();

/// The tolerances of a comparison. They mean the same as in OpenImageIO's idiff.
struct CompareParams {
    double fail = 0;                  ///< errors up to this are within tolerance [unit of the values]
    double relative = 0;              ///< errors up to this share of max(|a|, |b|) are, too
    double failPercent = 0;           ///< share of the compared voxels that may fail [%]
    bool inactive = false;            ///< also compare inactive voxels where either grid differs from its background
    double transformTolerance = 1e-3; ///< largest shift of a voxel between the transforms [voxels]
    std::vector<std::string> ignoredMetadata = creationMetadata(); ///< names; a final `*` matches any ending

    /// @throws ParameterError naming the parameter, its value and its range
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(CompareParams& params);

/// Compare two grids; their names do not matter.
///
/// Supported are float, double, int32, int64, bool, mask, Vec3 of float, double and int32, and point data. A tile
/// equals a leaf of the same values. Leaves are compared in parallel; the result, sums included, is bit-identical for
/// any number of threads. The grids must not be changed meanwhile.
/// @throws ParameterError, or InputError if the grids are of a type that cannot be compared
[[nodiscard]] GridDifference compareGrids(const openvdb::GridBase& a, const openvdb::GridBase& b,
                                          const CompareParams& params = {});

/// |A − B| of two grids of one type, on A's transform, under A's name, with the active voxels of both.
///
/// The result is float for float, bool and mask; double for double, int32 and int64; Vec3 of float for Vec3 of float;
/// Vec3 of double for other vectors, by component. Two NaNs and two equal infinities give 0; a finite value against
/// one that is not gives infinity.
/// @return null for points and for grids of different types
[[nodiscard]] std::shared_ptr<openvdb::GridBase> differenceGrid(const openvdb::GridBase& a, const openvdb::GridBase& b);

/// Compare two files: their metadata, and their grids, which are matched by name and, among equal names, by order.
/// @throws InputError if a file cannot be read or holds a grid that cannot be compared, ParameterError
[[nodiscard]] FileDifference compareFiles(const std::filesystem::path& a, const std::filesystem::path& b,
                                          const CompareParams& params = {});

/// Compare two volumes in memory, as compareFiles() does. Their paths name them in the result and in messages.
/// @throws InputError if they hold grids that cannot be compared, ParameterError
[[nodiscard]] FileDifference compareVolumes(const VdbFile& a, const VdbFile& b, const CompareParams& params = {});

/// Two sequences to compare, and the outputs.
struct CompareSequencesParams {
    std::string a, b;          ///< two files or two patterns
    std::string frames;        ///< a frame list; empty for every frame found on either side
    std::string output;        ///< file or pattern for |A − B|; empty for none
    bool skipExisting = false; ///< leave out frames whose output exists
    std::string json;          ///< file for the report; empty for none
    CompareParams compare;

    /// @throws ParameterError on contradictions
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(CompareSequencesParams& params);

/// Compare two sequences by frame number and report each frame as soon as it is compared.
///
/// A frame that is missing on one side is a difference. Memory holds the grids of one frame at a time.
/// @throws InputError if a file cannot be read, a side has no frames, or a selected frame is missing on both sides;
/// OutputError; ParameterError
[[nodiscard]] SequenceDifference compareSequences(const CompareSequencesParams& params, Reporter& reporter);

} // namespace vdblic
