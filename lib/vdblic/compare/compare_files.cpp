#include "vdblic/compare/compare.h"

#include "vdblic/compare/metadata_difference.h"
#include "vdblic/compare/report.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/input_files.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/io/sequence.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/whole_vdb.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <system_error>
#include <utility>

namespace vdblic {
namespace {

/// The grids of one name and occurrence in A and B; null where it is missing.
struct GridPair {
    openvdb::GridBase::Ptr a, b;
    std::string name;
    int occurrence = 0;
};

/// The grids of A in its order, then the grids of B without a partner.
std::vector<GridPair> pairGrids(const VdbFile& a, const VdbFile& b)
{
    std::vector<GridPair> pairs;
    std::map<std::pair<std::string, int>, std::size_t> indexOf;
    std::map<std::string, int> seenA, seenB;
    for (const auto& grid : a.grids) {
        const std::string name = grid->getName();
        const int occurrence = seenA[name]++;
        indexOf[{name, occurrence}] = pairs.size();
        pairs.push_back({grid, nullptr, name, occurrence});
    }
    for (const auto& grid : b.grids) {
        const std::string name = grid->getName();
        const int occurrence = seenB[name]++;
        if (const auto found = indexOf.find({name, occurrence}); found != indexOf.end())
            pairs[found->second].b = grid;
        else
            pairs.push_back({nullptr, grid, name, occurrence});
    }
    return pairs;
}

GridDifference comparePair(const GridPair& pair, const CompareParams& params)
{
    GridDifference result;
    if (pair.a && pair.b) {
        result = compareGrids(*pair.a, *pair.b, params);
    } else {
        if (pair.a) result.typeA = pair.a->valueType();
        if (pair.b) result.typeB = pair.b->valueType();
    }
    result.name = pair.name;
    result.occurrence = pair.occurrence;
    return result;
}

/// The same with errors that name the files.
GridDifference comparePair(const GridPair& pair, const CompareParams& params, const FileDifference& files)
{
    try {
        return comparePair(pair, params);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{} | {}: {}", files.pathA, files.pathB, error.what()));
    } catch (const openvdb::Exception& error) { // such as a transform that has no inverse
        throw InputError(fmt::format("{} | {}: grid '{}': {}", files.pathA, files.pathB, pair.name, error.what()));
    }
}

/// Compare the volumes of a frame, and write |A − B| if `output` is given.
FileDifference compareVolumes(const VdbFile& a, const VdbFile& b, const CompareParams& params,
                              const std::optional<std::filesystem::path>& output, Reporter& reporter)
{
    FileDifference result{a.path.string(), b.path.string(), {}, {}};
    result.metadata = compare::compareMetadata(a.metadata, b.metadata, params.ignoredMetadata);
    openvdb::GridCPtrVec differences;
    for (const GridPair& pair : pairGrids(a, b)) {
        result.grids.push_back(comparePair(pair, params, result));
        if (!output) continue;
        const openvdb::GridBase::Ptr grid = pair.a && pair.b ? differenceGrid(*pair.a, *pair.b) : nullptr;
        if (grid)
            differences.push_back(grid);
        else
            reporter.say(fmt::format("grid '{}' has no |A - B|: {}", pair.name,
                                     !pair.a || !pair.b                 ? "it is in one file only"
                                     : pair.a->type() != pair.b->type() ? "its types are not the same"
                                                                        : "points have none"));
    }
    if (output) {
        writeVdb(*output, differences, {});
        reporter.finished(*output);
    }
    return result;
}

bool isOnDisk(const std::filesystem::path& path)
{
    std::error_code ignored;
    return std::filesystem::exists(path, ignored);
}

/// The frames to compare, and the sides that have them.
std::vector<FrameDifference> matchFrames(const CompareSequencesParams& params)
{
    for (const std::string& side : {params.a, params.b}) {
        if (side == "-") throw ParameterError("paths on standard input cannot be compared; name a file or a pattern");
    }
    const FramePattern a(params.a), b(params.b);
    if (a.hasField() != b.hasField()) {
        throw ParameterError(fmt::format("'{}' is one file and '{}' is a pattern; compare files with files and "
                                         "sequences with sequences",
                                         a.hasField() ? params.b : params.a, a.hasField() ? params.a : params.b));
    }
    std::vector<FrameDifference> matched;
    if (!a.hasField()) {
        const FrameFile fileA = selectFrames({params.a, params.frames}).front();
        const FrameFile fileB = selectFrames({params.b, params.frames}).front();
        matched.push_back({fileA.frame, true, true, {fileA.path.string(), fileB.path.string(), {}, {}}});
        return matched;
    }

    std::set<std::int64_t> frames;
    if (params.frames.empty()) {
        for (const FramePattern* side : {&a, &b}) {
            const auto found = side->framesOnDisk();
            if (found.empty()) throw InputError(fmt::format("{}: no file matches the pattern", side->text()));
            frames.insert(found.begin(), found.end());
        }
    } else {
        const auto chosen = parseFrameList(params.frames);
        frames.insert(chosen.begin(), chosen.end());
    }
    for (const std::int64_t frame : frames) {
        const std::filesystem::path pathA = a.path(frame), pathB = b.path(frame);
        const bool inA = isOnDisk(pathA), inB = isOnDisk(pathB);
        if (!inA && !inB) {
            throw InputError(
                fmt::format("frame {} is missing on both sides: {}, {}", frame, pathA.string(), pathB.string()));
        }
        matched.push_back({frame, inA, inB, {pathA.string(), pathB.string(), {}, {}}});
    }
    return matched;
}

InputFiles inputsOf(const std::vector<FrameDifference>& frames)
{
    InputFiles inputs;
    for (const FrameDifference& frame : frames) {
        inputs.add(frame.files.pathA);
        inputs.add(frame.files.pathB);
    }
    return inputs;
}

} // namespace

Parameters parametersOf(CompareSequencesParams& params)
{
    const Parameters inputs = {
        parameter("a", "One .vdb file, or a pattern: name.%04d.vdb, also ####, @@@@, $F4, <F4>.", params.a,
                  {.option = "A", .isRequired = true}),
        parameter("b", "The file or pattern to compare with; frames are matched by number.", params.b,
                  {.option = "B", .isRequired = true}),
        parameter("frames", "Frames to compare: 1-100, 1-100x2 or 1,5,9-20; every frame by default.", params.frames),
    };
    const Parameters outputs = {
        parameter("output", "File or pattern to write |A - B| grids to.", params.output, {.option = "-o,--output"}),
        skipExistingParameter(params.skipExisting),
        parameter("json", "File to write the whole report to.", params.json, {.words = "FILE"}),
    };
    return joined({inputs, parametersOf(params.compare), outputs});
}

void CompareSequencesParams::validate() const
{
    compare.validate();
    if (!output.empty()) checkExtension(output, {".vdb"});
    if (skipExisting && output.empty()) throw ParameterError("`skip_existing` needs `output` to look for");
}

FileDifference compareFiles(const std::filesystem::path& a, const std::filesystem::path& b, const CompareParams& params)
{
    return compareVolumes(readVdb(a), readVdb(b), params);
}

FileDifference compareVolumes(const VdbFile& a, const VdbFile& b, const CompareParams& params)
{
    params.validate();
    Reporter silent;
    return compareVolumes(a, b, params, std::nullopt, silent);
}

SequenceDifference compareSequences(const CompareSequencesParams& params, Reporter& reporter)
{
    params.validate();
    const std::vector<FrameDifference> frames = matchFrames(params);
    const InputFiles inputs = inputsOf(frames);
    std::optional<FramePattern> output;
    if (!params.output.empty()) {
        output.emplace(params.output);
        std::vector<std::int64_t> numbers;
        numbers.reserve(frames.size());
        for (const FrameDifference& frame : frames)
            numbers.push_back(frame.frame);
        checkOutputs(*output, numbers);
        for (const FrameDifference& frame : frames)
            inputs.check(output->path(frame.frame));
    }
    if (!params.json.empty()) {
        inputs.check(params.json);
        if (output) checkNoFrame(params.json, *output);
        checkReport(params.json);
    }

    SequenceDifference result{params.a, params.b, {}};
    std::size_t skipped = 0;
    for (FrameDifference frame : frames) {
        reporter.checkStop();
        const auto path = output ? std::optional(output->path(frame.frame)) : std::nullopt;
        if (params.skipExisting && isWholeVdb(*path, reporter)) {
            reporter.finished(*path);
            ++skipped;
            continue;
        }
        if (frame.inA && frame.inB) {
            frame.files =
                compareVolumes(readVdb(frame.files.pathA), readVdb(frame.files.pathB), params.compare, path, reporter);
        }
        for (const std::string& line : reportLines(frame))
            reporter.say(line);
        for (const std::string& line : detailLines(frame))
            reporter.detail(line);
        result.frames.push_back(std::move(frame));
        reporter.progress(result.frames.size(), frames.size());
    }
    if (params.skipExisting) reporter.say(fmt::format("{} of {} files were there already", skipped, frames.size()));
    if (!params.json.empty()) {
        if (writeReport(params.json, toJson(result, params.compare))) reporter.finished(params.json);
    }
    return result;
}

} // namespace vdblic
