#include "vdblic/render/loaded_lines.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/io/frame_pattern.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/vdb_header.h"
#include "vdblic/lines/line_grid.h"
#include "vdblic/lines/lines_between.h"
#include "vdblic/render/frame_metadata.h"
#include "vdblic/render/moment.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/view.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using LineGrid = openvdb::points::PointDataGrid;

/// Call a function. @throws its InputError with the path in front
template<typename Function>
auto named(const std::filesystem::path& path, const Function& function)
{
    try {
        return function();
    } catch (const InputError& error) {
        const bool isNamed = std::string_view(error.what()).starts_with(path.string());
        throw isNamed ? error : InputError(fmt::format("{}: {}", path.string(), error.what()));
    }
}

/// The grid of lines; null if the file has none.
LineGrid::Ptr gridIn(const PicturePlan& plan, const VdbFile& file)
{
    return file.find<LineGrid>(textureName(file.metadata, plan.texture));
}

/// The values of a scalar of lines, one a point. @throws InputError naming the file
std::vector<float> scalarOf(const Lines& lines, const std::string& name, const VdbFile& file, const char* option)
{
    if (name == kSourceGrid) {
        std::vector<float> values(lines.pointCount());
        for (const Lines::Line& line : lines.lines)
            std::fill(values.begin() + line.begin, values.begin() + line.end, float(line.source));
        return values;
    }
    if (name == kLineAge || lines.lines.empty()) return lines.ages; // without points there are no scalars
    std::vector<std::string> names{kLineAge, kSourceGrid};
    for (const Lines::Scalar& scalar : lines.scalars) {
        if (scalar.name == name) return scalar.values;
        names.push_back(scalar.name);
    }
    throw InputError(fmt::format("{}: its lines have no scalar '{}', but {}; choose with {}, or make it with "
                                 "vdblic_advect --with {}",
                                 file.path.string(), name, fmt::join(names, ", "), option, name));
}

/// The first of `names` that the lines have; the first name if they have none of them.
std::string chosenScalar(const Lines& lines, const std::vector<std::string>& names)
{
    const auto has = [&](const std::string& name) {
        return name == kSourceGrid || name == kLineAge ||
               std::ranges::any_of(lines.scalars, [&](const Lines::Scalar& scalar) { return scalar.name == name; });
    };
    const auto found = std::ranges::find_if(names, has);
    return found == names.end() ? names.front() : *found;
}

/// The unit of a scalar of lines: the unit of the grid of its name in the file.
std::string unitIn(const VdbFile& file, const std::string& scalar, const std::string& lengthUnit)
{
    const auto grid = file.find<openvdb::FloatGrid>(scalar);
    return grid ? unitOf(*grid, lengthUnit) : "";
}

/// @param file of the lines, or of the frame before them
LoadedTexture loadLines(const PicturePlan& plan, const VdbFile& file, const Lines& lines,
                        const openvdb::math::Transform& transform, const FrameFile& frame,
                        const std::string& chosenOpacity)
{
    std::vector<std::string> opacityBy = plan.opacityBy;
    if (!chosenOpacity.empty() && !opacityBy.empty()) opacityBy = {chosenOpacity};
    const std::string driver = opacityBy.empty() ? plan.colorBy : chosenScalar(lines, opacityBy);
    const bool two = driver != plan.colorBy || !plan.look.transfer.sharesRange();
    Tubes::Values values;
    if (two) values.color = scalarOf(lines, plan.colorBy, file, "`color_by`");
    values.driver = scalarOf(lines, driver, file, opacityBy.empty() ? "`by`" : "`opacity_by`");
    std::optional<FrameDomain> region;
    if (!plan.region.empty() || plan.regionBox) {
        const auto voxels = std::make_shared<openvdb::MaskTree>();
        for (const openvdb::Vec3f& point : lines.positions)
            voxels->setValueOn(openvdb::Coord::round(openvdb::Vec3d(point)));
        const DomainParams params{.mask = plan.region, .worldBox = plan.regionBox};
        region = makeDomain(voxels, transform, params, frame.frame);
    }
    const auto isShown = [&](const openvdb::Coord& voxel) {
        return !region || region->texture->topology().isValueOn(voxel);
    };
    const std::string lengthUnit = textOf(file.metadata, "length_unit");
    std::vector<std::string> kinds;
    if (plan.colorBy == kSourceGrid) kinds = kindsOf(file.metadata);
    return LoadedTexture{
        .file = frame,
        .name = textureName(file.metadata, plan.texture),
        .opacityBy = driver,
        .tubes = std::optional<Tubes>(std::in_place, lines, std::move(values), transform, plan.stretch, isShown),
        .clock = clockOf(file.metadata),
        .colorUnit = unitIn(file, plan.colorBy, lengthUnit),
        .opacityUnit = unitIn(file, driver, lengthUnit),
        .lengthUnit = lengthUnit,
        .kinds = std::move(kinds),
        .isSparse = true,
        .flowVoxels = file.find<openvdb::FloatGrid>(kSpeedGrid)};
}

std::string linesInLines(const std::filesystem::path& path)
{
    return fmt::format("{}: holds lines itself; `lines` are drawn in a texture of voxels", path.string());
}

std::string noLines(const std::filesystem::path& path)
{
    return fmt::format("{}: holds no lines for `lines`; make them with vdblic_advect --method streaks --draw lines",
                       path.string());
}

/// The file of the lines in a frame's voxels. @throws InputError if it is missing
FrameFile foundLines(const PicturePlan& plan, std::int64_t frame)
{
    FrameFile file{frame, linesFile(plan, frame)};
    if (std::filesystem::exists(file.path)) return file;
    throw InputError(fmt::format("{}: the lines of frame {} are missing; make them with vdblic_advect --method "
                                 "streaks --draw lines, or leave the frame out with `frames`",
                                 file.path.string(), frame));
}

} // namespace

std::filesystem::path linesFile(const PicturePlan& plan, std::int64_t frame)
{
    return FramePattern(plan.lines).path(frame);
}

bool hasLines(const std::filesystem::path& path, const std::string& name)
{
    const VdbHeader header = readVdbHeader(path);
    const std::string texture = textureName(header.metadata, name);
    return std::ranges::any_of(header.grids, [&](const openvdb::GridBase::Ptr& grid) {
        return grid->getName() == texture && grid->isType<LineGrid>();
    });
}

void checkLines(const PicturePlan& plan, const FrameFile& frame)
{
    if (plan.lines.empty()) return;
    if (hasLines(frame.path, plan.texture)) throw InputError(linesInLines(frame.path));
    const FrameFile lines = foundLines(plan, frame.frame);
    if (!hasLines(lines.path, "")) throw InputError(noLines(lines.path));
}

std::optional<LoadedTexture> linesIn(const PicturePlan& plan, const VdbFile& file, const FrameFile& frame,
                                     const std::string& chosenOpacity)
{
    const LineGrid::Ptr grid = gridIn(plan, file);
    if (!grid) return std::nullopt;
    if (!plan.lines.empty()) throw InputError(linesInLines(frame.path));
    return named(frame.path,
                 [&] { return loadLines(plan, file, linesOf(*grid), grid->transform(), frame, chosenOpacity); });
}

std::shared_ptr<const LoadedTexture> linesBeside(const PicturePlan& plan, const FrameFile& frame, const View* view)
{
    const FrameFile file = foundLines(plan, frame.frame);
    auto lines =
        linesIn(planOfLines(plan), readVdb(file.path), file, view && view->lines ? view->lines->opacityBy : "");
    if (!lines) throw InputError(noLines(file.path));
    return std::make_shared<const LoadedTexture>(std::move(*lines));
}

namespace {

/// A file's lines at one end of an interval.
struct FrameLines {
    VdbFile file;
    LineGrid::Ptr grid;
    Lines lines;
};

FrameLines readLines(const PicturePlan& plan, const FrameFile& frame)
{
    FrameLines read{readVdb(frame.path), nullptr, {}};
    read.grid = gridIn(plan, read.file);
    if (!read.grid) {
        throw InputError(fmt::format("{}: holds no lines, which `substeps` moves; vdblic_advect --substeps makes "
                                     "textures between frames",
                                     frame.path.string()));
    }
    read.lines = named(frame.path, [&] { return linesOf(*read.grid); });
    return read;
}

/// A number in a file's metadata. @throws InputError
double numberOf(const VdbFile& file, const char* key)
{
    const std::optional<double> number = numericMetadata(file.metadata, key);
    if (number && std::isfinite(*number)) return *number;
    throw InputError(fmt::format("{}: no number `{}` in its metadata, which tells how lines move between frames; make "
                                 "them with vdblic_advect",
                                 file.path.string(), key));
}

/// The transform at a moment: of an observer who moves along, between those of the frames.
openvdb::math::Transform::Ptr transformBetween(const FrameLines& before, const FrameLines& after, double share)
{
    const openvdb::math::Transform &first = before.grid->transform(), &second = after.grid->transform();
    const openvdb::Vec3d way = second.indexToWorld(openvdb::Vec3d(0)) - first.indexToWorld(openvdb::Vec3d(0));
    const auto moved = [&](double part) {
        auto transform = first.copy();
        if (first != second) transform->postTranslate(way * part);
        return transform;
    };
    if (*moved(1) == second) return moved(share);
    throw InputError(fmt::format("{}: its lines are turned or scaled against the frame before; make them with "
                                 "vdblic_advect --substeps",
                                 after.file.path.string()));
}

/// The time between two frames, in the units of ages.
double intervalBetween(const VdbFile& before, const VdbFile& after)
{
    constexpr double kLeastTail = 1.1; // intervals: the faint end of a tail is left out of the file
    const double textures = (numberOf(after, "time") - numberOf(before, "time")) / numberOf(after, "dt");
    const double interval = textures / numberOf(after, "substeps");
    if (!(interval > 0 && std::isfinite(interval))) {
        throw InputError(fmt::format("{}: its `time` {} is not after the frame before, {}", after.path.string(),
                                     numberOf(after, "time"), numberOf(before, "time")));
    }
    const double tail = numberOf(after, "tail");
    if (tail >= kLeastTail * interval) return interval;
    throw InputError(
        fmt::format("{}: its tails of {:.3g} frames leave gaps between frames; make them with --tail {:.2g} "
                    "or more, or with --substeps",
                    after.path.string(), tail, kLeastTail * interval));
}

} // namespace

LoadedTexture linesAt(const PicturePlan& plan, const Moment& moment, const View* view)
{
    const FrameLines before = readLines(plan, moment.file), after = readLines(plan, *moment.next);
    const double interval = intervalBetween(before.file, after.file);
    const auto transform = transformBetween(before, after, moment.share);
    const Lines lines = linesBetween(before.lines, after.lines, moment.share, interval);
    LoadedTexture loaded = named(moment.file.path, [&] {
        return loadLines(plan, before.file, lines, *transform, moment.file, view ? view->opacityBy : "");
    });
    const double from = numberOf(before.file, "time"), to = numberOf(after.file, "time");
    loaded.clock.time = from + (to - from) * moment.share;
    loaded.after = moment.after();
    return loaded;
}

} // namespace vdblic
