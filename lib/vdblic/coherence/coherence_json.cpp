#include "vdblic/coherence/coherence_report.h"

#include "vdblic/io/json_file.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

using Json = nlohmann::ordered_json;

Json finiteOrNull(double value)
{
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json numbers(const std::vector<double>& values)
{
    Json result = Json::array();
    for (const double value : values)
        result.push_back(finiteOrNull(value));
    return result;
}

Json ofFigures(const CoherenceFigures& figures)
{
    Json result;
    for (const NamedFigure& figure : kNamedFigures)
        result[figure.name] = finiteOrNull(figures.*figure.value);
    result["along"] = numbers(figures.along);
    result["across"] = numbers(figures.across);
    return result;
}

Json ofClass(std::size_t displacementClass, std::size_t points)
{
    const auto& [from, to] = kDisplacementClasses[displacementClass];
    return {{"from", from}, {"to", to}, {"points", points}};
}

Json ofClasses(const CleannessByClass& classes)
{
    Json result = Json::array();
    for (std::size_t i = 0; i < classes.size(); ++i) {
        Json figures = ofClass(i, classes[i].points);
        for (const CleannessFigure& figure : kCleannessFigures)
            figures[figure.name] = finiteOrNull(classes[i].*figure.value);
        result.push_back(figures);
    }
    return result;
}

Json ofEstimate(const Estimate& estimate)
{
    return {{"mean", finiteOrNull(estimate.mean)},
            {"half_width", finiteOrNull(estimate.halfWidth)},
            {"frames", estimate.frames}};
}

Json ofMeans(const std::array<MeanCleanness, kDisplacementClasses.size()>& classes)
{
    Json result = Json::array();
    for (std::size_t i = 0; i < classes.size(); ++i) {
        Json means = ofClass(i, classes[i].points);
        for (std::size_t k = 0; k < kCleannessFigures.size(); ++k)
            means[kCleannessFigures[k].name] = ofEstimate(classes[i].figures[k]);
        result.push_back(means);
    }
    return result;
}

Json ofFrame(const FrameCoherence& frame)
{
    Json result = {{"frame", frame.frame},
                   {"points", frame.points},
                   {"temporal_points", frame.temporalPoints},
                   {"raw", ofFigures(frame.raw)},
                   {"smoothed", ofFigures(frame.smoothed)},
                   {"by_displacement", ofClasses(frame.byDisplacement)}};
    if (frame.hits) result["hits"] = {{"mean", frame.hits->mean}, {"zero_share", frame.hits->zeroShare}};
    return result;
}

Json ofSparse(const SparseCoherence& frame)
{
    Json result = {{"frame", frame.frame}, {"points", frame.points}, {"heads", frame.heads}};
    for (const NamedSparseFigure& figure : kSparseFigures)
        result[figure.name] = finiteOrNull(frame.figures.*figure.value);
    return result;
}

Json ofSparseMeans(const std::array<Estimate, kSparseFigures.size()>& means)
{
    Json result;
    for (std::size_t i = 0; i < means.size(); ++i)
        result[kSparseFigures[i].name] = ofEstimate(means[i]);
    return result;
}

Json ofMeans(const MeanFigures& means)
{
    Json result;
    for (std::size_t i = 0; i < kNamedFigures.size(); ++i)
        result[kNamedFigures[i].name] = ofEstimate(means.figures[i]);
    result["along"] = numbers(means.along);
    result["across"] = numbers(means.across);
    return result;
}

} // namespace

std::string toJson(const SequenceCoherence& coherence, const SequenceCoherenceParams& params)
{
    Json frames = Json::array();
    for (const FrameCoherence& frame : coherence.frames)
        frames.push_back(ofFrame(frame));
    for (const SparseCoherence& frame : coherence.sparse)
        frames.push_back(ofSparse(frame));
    Json report = {{"velocity", params.flow.input.pattern}, {"texture", params.texture}};
    if (coherence.refine != std::array{1, 1, 1}) report["refine"] = coherence.refine;
    report["parameters"] = {{"texture_name", params.textureName.empty() ? "by metadata" : params.textureName},
                            {"samples", params.coherence.samples},
                            {"least_motion", params.coherence.leastMotion}};
    if (!coherence.sparse.empty()) {
        report["parameters"].erase("least_motion");
        report["frames"] = frames;
        report["mean"] = ofSparseMeans(coherence.sparseMeans);
    } else {
        report["lags"] = coherence.lags;
        report["frames"] = frames;
        report["mean"] = {{"raw", ofMeans(coherence.raw)},
                          {"smoothed", ofMeans(coherence.smoothed)},
                          {"by_displacement", ofMeans(coherence.byDisplacement)}};
    }
    return jsonText(report);
}

} // namespace vdblic
