#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// The result of a comparison. Ordered: the verdict on several parts is the largest of theirs.
enum class Verdict { kSame, kDiffers };

/// One voxel (or point) whose value or activity differs.
struct VoxelDifference {
    std::array<std::int64_t, 3> index{}; ///< index space; for a point the voxel of A that holds it
    std::array<double, 3> world{};       ///< world position by A's transform
    std::string a, b;                    ///< the two values, as text
    bool activeInA = true, activeInB = true;
    double error = 0; ///< infinite if one value is not finite, or both are different infinities
};

/// Figures over all pairs of finite values, in the unit of the values.
struct ErrorFigures {
    double max = 0; ///< infinite if a pair differs and one value is not finite
    double mean = 0;
    double rms = 0;
};

/// How the values of two grids, or of one attribute of their points, differ.
///
/// The error of a pair is |a − b|; of vectors the length of a − b; of booleans and strings 1 if they differ. NaN equals
/// NaN and an infinity equals itself; any other pair with a value that is not finite exceeds every tolerance. For a
/// voxel active in one grid only, the stored values of both grids are compared.
struct ValueDifference {
    std::uint64_t compared = 0; ///< voxels active in either grid, or pairs of points
    ErrorFigures error;
    double maxRelative = 0;                 ///< largest |a − b| / max(|a|, |b|)
    double peak = 0;                        ///< largest finite |value| of both
    double psnr = 0;                        ///< 20 log10(peak / RMS) [dB]; infinite if RMS is 0
    std::vector<ErrorFigures> components;   ///< x, y, z of vectors; empty for other types
    std::uint64_t notFinite = 0;            ///< pairs left out of the figures: different, one not finite
    std::uint64_t overFail = 0;             ///< pairs above the failure tolerance
    std::uint64_t onlyInA = 0, onlyInB = 0; ///< voxels active in one grid only
    std::uint64_t failing = 0;              ///< above the failure tolerance or active in one grid only
    std::optional<VoxelDifference> first;   ///< the failing voxel with the least (x, y, z)
    std::optional<VoxelDifference> worst;   ///< the voxel of the largest error; least (x, y, z) among equals
    Verdict verdict = Verdict::kSame;       ///< by the given tolerances

    [[nodiscard]] double failingPercent() const
    {
        return compared > 0 ? 100. * static_cast<double>(failing) / static_cast<double>(compared) : 0.;
    }
};

/// A metadata entry that differs; no value on the side where it is missing.
struct MetadataDifference {
    std::string key;
    std::optional<std::string> a, b;
};

/// Transforms that map voxels to different positions.
struct TransformDifference {
    std::string a, b; ///< the affine matrices by rows, for row vectors; or the type of map
    double shift = 0; ///< the largest shift of an active voxel [voxels]
};

/// Different background values.
struct BackgroundDifference {
    std::string a, b;
};

/// One attribute of points; `P` is the world position, groups are booleans.
struct AttributeDifference {
    std::string name;
    std::string typeA, typeB;              ///< empty where the attribute is missing
    std::optional<ValueDifference> values; ///< none if missing on a side or if the types differ
    [[nodiscard]] Verdict verdict() const;
};

/// How two point grids differ.
struct PointDifference {
    std::uint64_t countA = 0, countB = 0;
    bool matchedById = false; ///< by the attribute `id`, else by order within each voxel
    std::uint64_t matched = 0;
    std::uint64_t onlyInA = 0, onlyInB = 0; ///< points without a partner
    Verdict countVerdict = Verdict::kSame;
    std::vector<AttributeDifference> attributes;
    [[nodiscard]] Verdict verdict() const;
};

/// The differences of two grids of the same name.
struct GridDifference {
    std::string name;
    int occurrence = 0;       ///< 0 for the first grid of this name in its file
    std::string typeA, typeB; ///< value types; empty where the grid is missing
    std::optional<TransformDifference> transform;
    std::optional<BackgroundDifference> background;
    std::vector<MetadataDifference> metadata;
    std::optional<ValueDifference> values; ///< none for points, a missing grid or different types
    std::optional<PointDifference> points;
    [[nodiscard]] bool isMissing() const { return typeA.empty() || typeB.empty(); }
    [[nodiscard]] Verdict verdict() const;
};

/// The differences of two files: the grids of A in file order, then the grids only in B.
struct FileDifference {
    std::string pathA, pathB;
    std::vector<MetadataDifference> metadata;
    std::vector<GridDifference> grids;
    [[nodiscard]] Verdict verdict() const;
};

/// One frame of two sequences; `files` holds only the paths if the frame is missing on a side.
struct FrameDifference {
    std::int64_t frame = 1;
    bool inA = true, inB = true;
    FileDifference files;
    [[nodiscard]] Verdict verdict() const;
};

/// How two sequences differ.
struct SequenceDifference {
    std::string a, b; ///< the patterns
    std::vector<FrameDifference> frames;
    [[nodiscard]] Verdict verdict() const;
};

} // namespace vdblic
