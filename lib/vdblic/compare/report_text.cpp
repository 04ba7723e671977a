#include "vdblic/compare/report.h"

#include <fmt/format.h>

#include <cstddef>
#include <optional>

namespace vdblic {
namespace {

std::string orMissing(const std::optional<std::string>& text)
{
    return text ? '\'' + *text + '\'' : "missing";
}

std::string describe(const VoxelDifference& voxel)
{
    const auto& [i, j, k] = voxel.index;
    const auto& [x, y, z] = voxel.world;
    std::string text = fmt::format("[{} {} {}] at ({:.6g} {:.6g} {:.6g}): {} | {}", i, j, k, x, y, z, voxel.a, voxel.b);
    if (voxel.activeInA != voxel.activeInB) text += voxel.activeInA ? ", active in A only" : ", active in B only";
    return text;
}

void addFigures(const std::string& indent, const ValueDifference& values, std::vector<std::string>& lines)
{
    if (values.onlyInA + values.onlyInB > 0) {
        lines.push_back(fmt::format("{}topology: {} voxels active in A only, {} in B only", indent, values.onlyInA,
                                    values.onlyInB));
    }
    lines.push_back(fmt::format("{}{} of {} over tolerance ({:.4g} %), max error {:.6g}, mean {:.6g}, RMS {:.6g}, PSNR "
                                "{:.4g} dB, max relative {:.4g}",
                                indent, values.failing, values.compared, values.failingPercent(), values.error.max,
                                values.error.mean, values.error.rms, values.psnr, values.maxRelative));
    for (std::size_t i = 0; i < values.components.size(); ++i) {
        const ErrorFigures& error = values.components[i];
        lines.push_back(fmt::format("{}{}: max error {:.6g}, mean {:.6g}, RMS {:.6g}", indent, "xyz"[i], error.max,
                                    error.mean, error.rms));
    }
    if (values.notFinite > 0) lines.push_back(fmt::format("{}{} not finite on one side", indent, values.notFinite));
    if (values.first) lines.push_back(fmt::format("{}first {}", indent, describe(*values.first)));
    if (values.worst) lines.push_back(fmt::format("{}worst {}", indent, describe(*values.worst)));
}

void addMetadata(const std::string& indent, const std::vector<MetadataDifference>& metadata,
                 std::vector<std::string>& lines)
{
    for (const MetadataDifference& item : metadata) {
        lines.push_back(fmt::format("{}metadata {}: {} | {}", indent, item.key, orMissing(item.a), orMissing(item.b)));
    }
    if (!metadata.empty()) lines.push_back(fmt::format("{}`ignore_metadata` leaves such names out", indent));
}

void addPoints(const PointDifference& points, std::vector<std::string>& lines)
{
    lines.push_back(fmt::format("    points: {} | {}, matched by {}: {}, without partner: {} | {}", points.countA,
                                points.countB, points.matchedById ? "id" : "voxel", points.matched, points.onlyInA,
                                points.onlyInB));
    for (const AttributeDifference& attribute : points.attributes) {
        const auto type = [](const std::string& text) { return text.empty() ? "missing" : text; };
        if (attribute.typeA != attribute.typeB) {
            lines.push_back(
                fmt::format("    attribute {}: {} | {}", attribute.name, type(attribute.typeA), type(attribute.typeB)));
        } else {
            lines.push_back(
                fmt::format("    attribute {} ({}): {}", attribute.name, attribute.typeA, toText(attribute.verdict())));
            addFigures("      ", *attribute.values, lines);
        }
    }
}

void addGrid(const GridDifference& grid, std::vector<std::string>& lines)
{
    const std::string name = grid.occurrence > 0 ? fmt::format("'{}' number {}", grid.name, grid.occurrence + 1)
                                                 : fmt::format("'{}'", grid.name);
    if (grid.isMissing()) {
        lines.push_back(fmt::format("  grid {} ({}) is in {} only", name, grid.typeA.empty() ? grid.typeB : grid.typeA,
                                    grid.typeA.empty() ? "B" : "A"));
        return;
    }
    if (grid.typeA != grid.typeB) {
        lines.push_back(fmt::format("  grid {}: type {} | {}", name, grid.typeA, grid.typeB));
    } else {
        lines.push_back(fmt::format("  grid {} ({}): {}", name, grid.typeA, toText(grid.verdict())));
    }
    if (grid.transform) {
        lines.push_back(fmt::format("    transform: {} | {}, moves voxels by up to {:.4g} voxels", grid.transform->a,
                                    grid.transform->b, grid.transform->shift));
    }
    if (grid.background)
        lines.push_back(fmt::format("    background: {} | {}", grid.background->a, grid.background->b));
    addMetadata("    ", grid.metadata, lines);
    if (grid.values) addFigures("    ", *grid.values, lines);
    if (grid.points) addPoints(*grid.points, lines);
}

} // namespace

std::string toText(Verdict verdict)
{
    return verdict == Verdict::kSame ? "same" : "different";
}

std::vector<std::string> reportLines(const FrameDifference& frame)
{
    std::vector<std::string> lines;
    const FileDifference& files = frame.files;
    lines.push_back(fmt::format("{} | {}: {}", files.pathA, files.pathB, toText(frame.verdict())));
    if (!frame.inA || !frame.inB) {
        lines.push_back(fmt::format("  frame {} is in {} only", frame.frame, frame.inA ? "A" : "B"));
        return lines;
    }
    addMetadata("  ", files.metadata, lines);
    for (const GridDifference& grid : files.grids) {
        if (grid.verdict() != Verdict::kSame) addGrid(grid, lines);
    }
    return lines;
}

std::vector<std::string> detailLines(const FrameDifference& frame)
{
    std::vector<std::string> lines;
    for (const GridDifference& grid : frame.files.grids) {
        if (grid.verdict() == Verdict::kSame) addGrid(grid, lines);
    }
    return lines;
}

} // namespace vdblic
