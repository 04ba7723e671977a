#pragma once

#include "vdblic/compare/difference.h"
#include "vdblic/core/reporter.h"

#include <openvdb/version.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {
class GridBase;
}
} // namespace openvdb

namespace vdblic {

/// Metadata that tells how and when a file was made, not what is in it.
[[nodiscard]] std::vector<std::string> creationMetadata();

/// What counts as a difference. Tolerances act as those of OpenImageIO's idiff do.
struct CompareParams {
    double fail = 0;                               ///< errors up to this are within tolerance [unit of the values]
    double relative = 0;                           ///< as are errors up to this share of the larger of |a| and |b|
    double failPercent = 0;                        ///< share of the compared voxels that may fail [%]
    std::optional<double> hardFail = std::nullopt; ///< yet one error over this fails [unit of the values]
    std::optional<double> warn = std::nullopt;     ///< errors over this are worth a warning [unit of the values]
    bool inactive = false;            ///< compare inactive voxels too, where either grid holds more than its background
    bool firstOnly = false;           ///< stop at the first difference; figures then cover what was seen
    double transformTolerance = 1e-3; ///< transforms may move a voxel this far [voxels]
    std::vector<std::string> ignoredMetadata = creationMetadata(); ///< names; a last `*` stands for any rest

    /// @throws ParameterError naming the parameter, its value and its range
    void validate() const;
};

/// Compare two grids, whatever they are called.
///
/// Float, double, int32, int64, bool, mask, Vec3 of float, double and int32, and point data. Tiles and
/// voxels that mean the same are the same. Leaf by leaf in parallel; the result, sums included, is bit-identical for
/// any number of threads. The grids are only read, and are not to be changed meanwhile.
/// @throws ParameterError, or InputError if the grids are of a type that cannot be compared
[[nodiscard]] GridDifference compareGrids(const openvdb::GridBase& a, const openvdb::GridBase& b,
                                          const CompareParams& params = {});

/// |A − B| of two grids of one type, on A's transform, under A's name, with the active voxels of both.
///
/// Float for float, bool and mask; double for double, int32 and int64; vectors component by component, of single
/// precision for single precision and else of double. Values that are both not-a-number or the same infinity give 0,
/// one that is finite against one that is not gives infinity.
/// @return null for points, and grids of two types
[[nodiscard]] std::shared_ptr<openvdb::GridBase> differenceGrid(const openvdb::GridBase& a, const openvdb::GridBase& b);

/// Compare two files: file metadata, and grids matched by name and, among equal names, by order.
/// @throws InputError if a file cannot be read or holds a grid that cannot be compared, ParameterError
[[nodiscard]] FileDifference compareFiles(const std::filesystem::path& a, const std::filesystem::path& b,
                                          const CompareParams& params = {});

/// What to compare, and where the results go.
struct CompareSequencesParams {
    std::string a, b;          ///< two files or two patterns
    std::string frames;        ///< a frame list; empty for every frame found on either side
    std::string output;        ///< file or pattern for |A − B|; empty for none
    bool skipExisting = false; ///< leave out frames whose output is there
    std::string json;          ///< file for the report; empty for none
    CompareParams compare;

    /// @throws ParameterError on contradictions
    void validate() const;
};

/// Compare two sequences frame by frame, by frame number, and report each frame as it is known.
///
/// A frame that one side has and the other has not is a difference. Holds the grids of one frame at a time.
/// @throws InputError if a file cannot be read, a side has no frame at all, or a frame asked for is missing on both
/// sides; OutputError; ParameterError
[[nodiscard]] SequenceDifference compareSequences(const CompareSequencesParams& params, Reporter& reporter);

} // namespace vdblic
