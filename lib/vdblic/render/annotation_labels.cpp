#include "vdblic/render/annotation_labels.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace vdblic {

glm::dvec2 Labels::extent(const std::string& text) const
{
    cairo_text_extents_t extents;
    cairo_text_extents(mCanvas.context(), text.c_str(), &extents);
    return {extents.x_advance, mTextSize};
}

LabelArea Labels::areaOf(const Label& label) const
{
    const glm::dvec2 half = extent(label.text) / 2.0 + 0.15 * mTextSize;
    return {label.middle - half, label.middle + half};
}

bool Labels::write(std::vector<Label>& labels)
{
    std::vector<LabelArea> areas;
    const auto isIn = [](const std::vector<LabelArea>& taken, const LabelArea& area) {
        return std::any_of(taken.begin(), taken.end(), [&](const LabelArea& other) { return area.overlaps(other); });
    };
    for (const Label& label : labels) {
        if (isIn(areas, areaOf(label))) return false;
        areas.push_back(areaOf(label));
    }
    std::vector<Label> kept;
    std::copy_if(labels.begin(), labels.end(), std::back_inserter(kept),
                 [&](const Label& label) { return areaOf(label).isInside(mSize) && !isIn(mTaken, areaOf(label)); });
    if (kept.empty() || 2 * kept.size() < labels.size()) return false;
    labels = std::move(kept);
    for (const Label& label : labels) {
        mCanvas.drawText(label.middle + glm::dvec2(0, 0.36 * mTextSize), 0.5, label.text);
        mTaken.push_back(areaOf(label));
    }
    return true;
}

} // namespace vdblic
