#include "vdblic/lic/coherence_report.h"

namespace vdblic {
namespace {

std::string both(const FrameCoherence& frame, double CoherenceFigures::*figure)
{
    return fmt::format("{:7.3f} |{:7.3f}", frame.raw.*figure, frame.smoothed.*figure);
}

std::string estimateText(const Estimate& estimate)
{
    return fmt::format("{:8.4f} ± {:6.4f}", estimate.mean, estimate.halfWidth);
}

} // namespace

std::string frameHeading()
{
    return fmt::format("{:>7} {:>7}  {:<16}  {:<16}  {:<16}  {:<16}  {:<16}", "frame", "points", "       temporal",
                       "     same place", "   along [voxel]", "  across [voxel]", "      deviation");
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

} // namespace vdblic
