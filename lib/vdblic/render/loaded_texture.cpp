#include "vdblic/render/loaded_texture.h"

#include "vdblic/core/errors.h"
#include "vdblic/field/derived_grids.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/field/resample.h"
#include "vdblic/io/frame_pattern.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/vdb_header.h"
#include "vdblic/io/velocity_grids.h"
#include "vdblic/lines/line_grid.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/sequence_bounds.h"
#include "vdblic/render/view.h"
#include "vdblic/volume/coarse_scalar.h"
#include "vdblic/volume/leaf_share.h"
#include "vdblic/volume/visible_space.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace vdblic {
namespace {

/// The message for a scalar grid that a file lacks, with the command that makes it.
InputError missingScalar(const VdbFile& file, const std::vector<std::string>& names, std::string choice)
{
    const auto made =
        std::find_first_of(names.begin(), names.end(), std::begin(kDerivedNames), std::end(kDerivedNames));
    if (made != names.end()) choice += fmt::format(", or make it with vdblic_advect --with {}", *made);
    return file.missing(fmt::format("float grid '{}'", fmt::join(names, "' or '")), choice);
}

/// The texture's grid. @throws InputError
openvdb::FloatGrid::Ptr textureOf(const VdbFile& file, const std::string& name)
{
    const auto isVelocity = [](const openvdb::GridBase::Ptr& grid) { return isVector(*grid); };
    if (!file.find<openvdb::FloatGrid>(name) && std::ranges::any_of(file.grids, isVelocity)) {
        throw InputError(fmt::format("{}: holds a velocity and no texture '{}'; vdblic_film shows a velocity, and "
                                     "vdblic_advect makes its texture",
                                     file.path.string(), name));
    }
    return file.get<openvdb::FloatGrid>(name, "`texture`");
}

/// The first of a file's float grids with one of these names.
openvdb::FloatGrid::Ptr findScalar(const VdbFile& file, const std::vector<std::string>& names)
{
    for (const std::string& name : names) {
        if (auto grid = file.find<openvdb::FloatGrid>(name)) return grid;
    }
    return nullptr;
}

/// A text of a file's or a grid's metadata; empty if it has none.
std::string textOf(const openvdb::MetaMap& metadata, const char* key)
{
    const auto text = metadata.getMetadata<openvdb::StringMetadata>(key);
    return text ? text->value() : "";
}

FrameClock clockOf(const openvdb::MetaMap& metadata)
{
    return {numericMetadata(metadata, "time"), numericMetadata(metadata, "dt"), textOf(metadata, "start")};
}

/// The unit of a scalar: its metadata `unit`, or for speeds the file's unit of length per second.
std::string unitOf(const openvdb::FloatGrid& scalar, const std::string& lengthUnit)
{
    std::string unit = textOf(scalar, "unit");
    if (!unit.empty() || scalar.getName() != kSpeedGrid || lengthUnit.empty()) return unit;
    return lengthUnit + "/s";
}

/// Names of the sources of streaks, the first for particles without one; empty if the file names none.
std::vector<std::string> kindsOf(const openvdb::MetaMap& metadata)
{
    std::vector<std::string> kinds = sourceNames(metadata);
    if (!kinds.empty()) kinds.insert(kinds.begin(), "no source");
    return kinds;
}

/// Of a sparse texture's file, a grid whose active voxels are the flow's. Sources have the streaks' voxels.
/// @param color grid that colour follows; or null
openvdb::FloatGrid::Ptr flowVoxelsOf(const VdbFile& file, const openvdb::FloatGrid::Ptr& color)
{
    if (color && color->getName() != kSourceGrid) return color;
    return file.find<openvdb::FloatGrid>(kSpeedGrid);
}

openvdb::FloatGrid::Ptr resampledOn(const openvdb::FloatGrid::Ptr& grid, const openvdb::FloatGrid& texture)
{
    const bool together = grid->transform() == texture.transform() || !grid->transform().isLinear();
    return together ? grid : resampled(*grid, texture);
}

/// Voxels around visible leaves whose records are read: lines read the next leaf too.
int rimOf(const PicturePlan& plan)
{
    return plan.look.shading.model == ShadingModel::kLine ? LeafVoxel::kDim : 0;
}

/// The memory of a leaf of a frame's two grids, and of the tables of its picture.
constexpr double kLeafBytes =
    2 * (sizeof(openvdb::FloatTree::LeafNodeType::Buffer) + LeafVoxel::kCount * sizeof(float)) +
    double(VisibleSpace::kBytesPerLeaf);

} // namespace

openvdb::FloatGrid::ConstPtr LoadedTexture::domain() const
{
    if (!flowVoxels && tubes) {
        throw InputError(fmt::format("{}: `solid` domain needs the flow's voxels beside the lines; make them with "
                                     "vdblic_advect --with {}",
                                     file.path.string(), kSpeedGrid));
    }
    if (!flowVoxels) return texture;
    constexpr int kFine = 4; // voxels: a level set rounds its edges over about one
    Refinement refinement;
    if (tubes) refinement.factors.fill(kFine);
    const auto ofTexture = tubes ? std::nullopt : Refinement::between(flowVoxels->transform(), texture->transform());
    if (ofTexture) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            refinement.factors[axis] = std::min(ofTexture->factors[axis], kFine);
    }
    const openvdb::MaskTree voxels(flowVoxels->tree(), false, true, openvdb::TopologyCopy());
    auto finer = openvdb::FloatGrid::create(
        std::make_shared<openvdb::FloatTree>(*refinement.refined(voxels), 0.0f, openvdb::TopologyCopy()));
    finer->setName(flowVoxels->getName());
    finer->setTransform(refinement.refined(flowVoxels->transform()));
    return finer;
}

void LoadedTexture::addTo(TextureHistograms& histograms) const
{
    if (tubes) {
        const VolumeSamples samples = tubes->samples();
        histograms.add(samples);
        return;
    }
    try {
        const auto onTexture = resampledOn(color, *texture);
        histograms.add(*texture, *onTexture, opacity == color ? *onTexture : *resampledOn(opacity, *texture));
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", file.path.string(), error.what()));
    }
}

double LoadedTexture::bytes() const
{
    const double own = tubes ? tubes->bytes() : double(volume->leafCount()) * (kLeafBytes + volume->bytesPerLeaf());
    return own + (lines ? lines->bytes() : 0);
}

std::filesystem::path linesFile(const PicturePlan& plan, std::int64_t frame)
{
    return FramePattern(plan.lines).path(frame);
}

double bytesPerVoxel(const PicturePlan& plan)
{
    const bool hasLines = plan.look.shading.model == ShadingModel::kLine;
    const int scalars = plan.opacityBy.empty() ? 1 : 2;
    const double records = TextureVolume::bytesPerLeaf(hasLines, scalars * double(ScalarLeaf::kSize * sizeof(float)));
    return (kLeafBytes + records) / LeafVoxel::kCount;
}

namespace {

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
std::string unitOf(const VdbFile& file, const std::string& scalar, const std::string& lengthUnit)
{
    const auto grid = file.find<openvdb::FloatGrid>(scalar);
    return grid ? unitOf(*grid, lengthUnit) : "";
}

/// @param chosenOpacity scalar that opacity follows in all frames; empty: not chosen yet
LoadedTexture loadLines(const PicturePlan& plan, const VdbFile& file, const openvdb::GridBase& grid,
                        const FrameFile& frame, const std::string& chosenOpacity)
{
    const Lines lines = linesOf(grid);
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
        region = makeDomain(voxels, grid.transform(), params, frame.frame);
    }
    const auto isShown = [&](const openvdb::Coord& voxel) {
        return !region || region->texture->topology().isValueOn(voxel);
    };
    const std::string lengthUnit = textOf(file.metadata, "length_unit");
    std::vector<std::string> kinds;
    if (plan.colorBy == kSourceGrid) kinds = kindsOf(file.metadata);
    return LoadedTexture{
        .file = frame,
        .name = grid.getName(),
        .opacityBy = driver,
        .tubes = std::optional<Tubes>(std::in_place, lines, std::move(values), grid.transform(), plan.stretch, isShown),
        .clock = clockOf(file.metadata),
        .colorUnit = unitOf(file, plan.colorBy, lengthUnit),
        .opacityUnit = unitOf(file, driver, lengthUnit),
        .lengthUnit = lengthUnit,
        .kinds = std::move(kinds),
        .isSparse = true,
        .flowVoxels = file.find<openvdb::FloatGrid>(kSpeedGrid)};
}

/// The lines of a file, if it has any. @throws InputError naming it
std::optional<LoadedTexture> linesIn(const PicturePlan& plan, const VdbFile& file, const FrameFile& frame,
                                     const std::string& chosenOpacity)
{
    const auto lines = file.find<openvdb::points::PointDataGrid>(textureName(file.metadata, plan.texture));
    if (!lines) return std::nullopt;
    try {
        return loadLines(plan, file, *lines, frame, chosenOpacity);
    } catch (const InputError& error) {
        const std::string path = frame.path.string();
        const bool isNamed = std::string_view(error.what()).starts_with(path);
        throw isNamed ? error : InputError(fmt::format("{}: {}", path, error.what()));
    }
}

/// The lines that are drawn in a frame's voxels. @throws InputError naming their file
std::shared_ptr<const LoadedTexture> linesBeside(const PicturePlan& plan, const FrameFile& frame, const View* view)
{
    const FrameFile file{frame.frame, linesFile(plan, frame.frame)};
    const std::string path = file.path.string();
    if (!std::filesystem::exists(file.path)) {
        throw InputError(fmt::format("{}: the lines of frame {} are missing; make them with vdblic_advect --method "
                                     "streaks --draw lines, or leave the frame out with `frames`",
                                     path, frame.frame));
    }
    const std::string chosen = view && view->lines ? view->lines->opacityBy : "";
    auto lines = linesIn(planOfLines(plan), readVdb(file.path), file, chosen);
    if (!lines) {
        throw InputError(fmt::format("{}: holds no lines for `lines`; make them with vdblic_advect --method streaks "
                                     "--draw lines",
                                     path));
    }
    return std::make_shared<const LoadedTexture>(std::move(*lines));
}

/// Whether a file is shown by its lines.
bool hasLines(const FrameFile& frame, const std::string& name)
{
    const VdbHeader header = readVdbHeader(frame.path);
    const std::string texture = textureName(header.metadata, name);
    return std::ranges::any_of(header.grids, [&](const openvdb::GridBase::Ptr& grid) {
        return grid->getName() == texture && grid->isType<openvdb::points::PointDataGrid>();
    });
}

} // namespace

LoadedTexture loadFrame(const PicturePlan& plan, const FrameFile& frame, const View* view, const LeafShare* share)
{
    // Lines need no voxel's value; each rank has all of them.
    const auto noValues = [](const openvdb::GridBase&, const openvdb::Coord&) { return false; };
    if (hasLines(frame, plan.texture)) return loadFrame(plan, readVdb(frame.path, noValues), frame, view);
    if (!share) return loadFrame(plan, readVdb(frame.path), frame, view);
    const std::optional<GridHeader> header = textureHeader(frame, plan.texture);
    // Records hold a voxel more on all sides, and their gradients another one. Other grids are to be resampled.
    const int rim = rimOf(plan) + LeafVoxel::kDim;
    const auto isKept = [&](const openvdb::GridBase& grid, const openvdb::Coord& origin) {
        return !header || share->needs(origin, rim) || grid.transform() != *header->transform;
    };
    const bool verifies = share->owns(openvdb::Coord(0)); // one rank does
    const VdbFile file = readVdb(frame.path, isKept, verifies);
    const std::string name = textureName(file.metadata, plan.texture);
    const auto texture = file.find<openvdb::FloatGrid>(name);
    if (header && texture && texture->transform() != *header->transform)
        throw InputError(fmt::format("{}: holds several grids '{}'; rename one", frame.path.string(), name));
    return loadFrame(plan, file, frame, view, share);
}

LoadedTexture loadFrame(const PicturePlan& plan, const VdbFile& file, const FrameFile& frame, const View* view,
                        const LeafShare* share)
{
    const std::string name = textureName(file.metadata, plan.texture);
    if (auto lines = linesIn(plan, file, frame, view ? view->opacityBy : "")) {
        if (plan.lines.empty()) return std::move(*lines);
        throw InputError(
            fmt::format("{}: holds lines itself; `lines` are drawn in a texture of voxels", frame.path.string()));
    }
    const auto texture = textureOf(file, name);
    std::vector<std::string> opacityBy = plan.opacityBy;
    if (view && !opacityBy.empty()) opacityBy = {view->opacityBy};
    const auto storedColor = findScalar(file, {plan.colorBy});
    if (!storedColor && plan.colorBy != kSpeedGrid)
        throw missingScalar(file, {plan.colorBy}, opacityBy.empty() ? "`by`" : "`color_by`");
    const auto storedOpacity = opacityBy.empty() ? storedColor : findScalar(file, opacityBy);
    if (!storedOpacity && !opacityBy.empty()) throw missingScalar(file, opacityBy, "`opacity_by`");
    const auto lines = plan.lines.empty() ? nullptr : linesBeside(plan, frame, view);
    try {
        const bool isSparse = vdblic::isSparse(file.metadata);
        const auto usable = [&](const openvdb::FloatGrid::Ptr& grid) {
            const bool isCoarse = isSparse && CoarseScalar::of(*grid, *texture);
            return isCoarse ? grid : resampledOn(grid, *texture);
        };
        const auto color = storedColor ? usable(storedColor) : texture;
        const auto opacity = storedOpacity && storedOpacity != storedColor ? usable(storedOpacity) : color;
        const bool hasLines = plan.look.shading.model == ShadingModel::kLine;
        const std::string lengthUnit = textOf(file.metadata, "length_unit");
        // The lines at a leaf's rim come from its neighbours.
        const RecordUse use{.look = hasLines || !view ? nullptr : &view->look,
                            .share = share,
                            .rim = rimOf(plan),
                            .isSparse = isSparse};
        LoadedTexture loaded{.file = frame,
                             .name = name,
                             .texture = texture,
                             .color = color,
                             .opacity = opacity,
                             .hasColor = bool(storedColor),
                             .opacityBy = storedOpacity ? storedOpacity->getName() : plan.colorBy,
                             .volume = TextureVolume(*texture, *opacity, plan.stretch, use),
                             .clock = clockOf(file.metadata),
                             .colorUnit = unitOf(*color, lengthUnit),
                             .opacityUnit = unitOf(*opacity, lengthUnit),
                             .lengthUnit = lengthUnit,
                             .isSparse = isSparse,
                             .lines = lines,
                             .flowVoxels = isSparse ? flowVoxelsOf(file, storedColor) : nullptr};
        if (color->getName() == kSourceGrid) loaded.kinds = kindsOf(file.metadata);
        if (opacity != color || !plan.look.transfer.sharesRange()) loaded.volume->addColors(*texture, *color);
        if (!plan.region.empty() || plan.regionBox) {
            const auto topology = std::make_shared<openvdb::MaskTree>(loaded.volume->domain().topology());
            const DomainParams region{.mask = plan.region, .worldBox = plan.regionBox};
            loaded.volume->cut(*makeDomain(topology, texture->transform(), region, frame.frame).texture);
        }
        if (hasLines) loaded.volume->addLines();
        return loaded;
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", frame.path.string(), error.what()));
    }
}

} // namespace vdblic
