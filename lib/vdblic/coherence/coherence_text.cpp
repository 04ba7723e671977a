#include "vdblic/coherence/coherence_report.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace vdblic {
namespace {

/// A number, or a dash if it is unknown. @param digits after the decimal point
std::string number(double value, int width, int digits)
{
    return std::isnan(value) ? fmt::format("{:>{}}", '-', width) : fmt::format("{:{}.{}f}", value, width, digits);
}

std::string both(const FrameCoherence& frame, double CoherenceFigures::*figure)
{
    return number(frame.raw.*figure, 7, 3) + " |" + number(frame.smoothed.*figure, 7, 3);
}

std::string estimateText(const Estimate& estimate)
{
    return number(estimate.mean, 8, 4) + " ± " + number(estimate.halfWidth, 6, 4);
}

} // namespace

std::string frameHeading()
{
    return fmt::format("{:>7} {:>7}  {:<16}  {:<16}  {:<16}  {:<16}  raw | smoothed", "frame", "points",
                       "       temporal", "     same place", "   along [voxel]", "  across [voxel]", "      deviation");
}

std::string frameLine(const FrameCoherence& frame)
{
    return fmt::format("{:7} {:7}  {}  {}  {}  {}  {}", frame.frame, frame.points,
                       both(frame, &CoherenceFigures::temporal), both(frame, &CoherenceFigures::samePlace),
                       both(frame, &CoherenceFigures::alongLength), both(frame, &CoherenceFigures::acrossLength),
                       both(frame, &CoherenceFigures::deviation));
}

std::vector<std::string> meanLines(const SequenceCoherence& coherence)
{
    std::vector<std::string> lines = {fmt::format("{:<14} {:^17}   {:^17}", "mean, 95 %", "raw", "smoothed")};
    for (std::size_t i = 0; i < kNamedFigures.size(); ++i) {
        lines.push_back(fmt::format("{:<14} {}   {}", kNamedFigures[i].name, estimateText(coherence.raw.figures[i]),
                                    estimateText(coherence.smoothed.figures[i])));
    }
    return lines;
}

std::string sparseHeading()
{
    std::string heading = fmt::format("{:>7} {:>7} {:>7}", "frame", "points", "heads");
    for (const NamedSparseFigure& figure : kSparseFigures)
        heading += fmt::format(" {:>11}", figure.name);
    return heading;
}

std::string sparseLine(const SparseCoherence& frame)
{
    std::string line = fmt::format("{:7} {:7} {:7}", frame.frame, frame.points, frame.heads);
    for (const NamedSparseFigure& figure : kSparseFigures)
        line += " " + number(frame.figures.*figure.value, 11, 3);
    return line;
}

std::vector<std::string> sparseMeanLines(const SequenceCoherence& coherence)
{
    std::vector<std::string> lines = {"mean, 95 %"};
    for (std::size_t i = 0; i < kSparseFigures.size(); ++i)
        lines.push_back(fmt::format("{:<14} {}", kSparseFigures[i].name, estimateText(coherence.sparseMeans[i])));
    return lines;
}

std::vector<std::string> displacementLines(const SequenceCoherence& coherence)
{
    std::vector<std::string> lines = {"by displacement a step [texture voxels], means of raw textures:",
                                      fmt::format("{:<10} {:>8}  {:>12} {:>6} {:>9} {:>10} {:>9} {:>11}", "", "points",
                                                  "isolated [%]", "line", "angle [°]", "deviation", "temporal",
                                                  "same place")};
    for (std::size_t i = 0; i < kDisplacementClasses.size(); ++i) {
        const auto& [from, to] = kDisplacementClasses[i];
        const MeanCleanness& means = coherence.byDisplacement[i];
        const auto& [isolated, line, angle, deviation, temporal, samePlace] = means.figures;
        const std::string figures =
            isolated.frames == 0
                ? fmt::format(" too few points: a frame needs {}", kLeastClassPoints)
                : fmt::format("{} {} {} {} {} {}", number(100 * isolated.mean, 12, 3), number(line.mean, 6, 2),
                              number(angle.mean, 9, 1), number(deviation.mean, 10, 3), number(temporal.mean, 9, 3),
                              number(samePlace.mean, 11, 3));
        lines.push_back(fmt::format("{:<10} {:>8}  {}", fmt::format("{} to {}", from, to), means.points, figures));
    }
    return lines;
}

} // namespace vdblic
