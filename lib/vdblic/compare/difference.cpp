#include "vdblic/compare/difference.h"

#include <algorithm>

namespace vdblic {
namespace {

template<typename Parts>
Verdict largest(const Parts& parts)
{
    Verdict verdict = Verdict::kSame;
    for (const auto& part : parts)
        verdict = std::max(verdict, part.verdict());
    return verdict;
}

} // namespace

Verdict AttributeDifference::verdict() const
{
    return values ? values->verdict : Verdict::kDiffers;
}

Verdict PointDifference::verdict() const
{
    return std::max(countVerdict, largest(attributes));
}

Verdict GridDifference::verdict() const
{
    if (typeA != typeB || transform || background || !metadata.empty()) return Verdict::kDiffers;
    if (points) return points->verdict();
    return values ? values->verdict : Verdict::kSame;
}

Verdict FileDifference::verdict() const
{
    return metadata.empty() ? largest(grids) : Verdict::kDiffers;
}

Verdict FrameDifference::verdict() const
{
    return inA && inB ? files.verdict() : Verdict::kDiffers;
}

Verdict SequenceDifference::verdict() const
{
    return largest(frames);
}

} // namespace vdblic
