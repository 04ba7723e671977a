#pragma once

#include "vdblic/image/cairo_drawing.h"
#include "vdblic/look/scalar_axis.h"
#include "vdblic/render/annotation_texts.h"
#include "vdblic/render/annotations.h"

#include <glm/vec2.hpp>

#include <string>
#include <vector>

namespace vdblic {

/// A rectangle of the picture [pixels].
struct LabelArea {
    glm::dvec2 low, high;

    [[nodiscard]] bool overlaps(const LabelArea& other) const
    {
        return low.x < other.high.x && other.low.x < high.x && low.y < other.high.y && other.low.y < high.y;
    }
    [[nodiscard]] bool isInside(const glm::dvec2& size) const
    {
        return low.x >= 0 && low.y >= 0 && high.x <= size.x && high.y <= size.y;
    }
};

/// A text around a point of the picture.
struct Label {
    std::string text;
    glm::dvec2 middle;
};

/// Writes texts into a picture, none over another and none over its border.
class Labels {
  public:
    /// @param canvas outlives this; its font is for all labels  @param textSize [pixels]
    Labels(const CairoCanvas& canvas, const glm::dvec2& size, double textSize)
        : mCanvas(canvas), mSize(size), mTextSize(textSize)
    {
    }

    [[nodiscard]] glm::dvec2 extent(const std::string& text) const; ///< of a text [pixels]
    /// Keep labels out of an area.
    void keepFree(const LabelArea& area) { mTaken.push_back(area); }
    /// Write texts if they do not overlap each other, and half of them or more are clear of earlier texts. The others
    /// are removed from the list. @return whether they are written
    bool write(std::vector<Label>& labels);

  private:
    [[nodiscard]] LabelArea areaOf(const Label& label) const;

    const CairoCanvas& mCanvas;
    glm::dvec2 mSize;
    double mTextSize;
    std::vector<LabelArea> mTaken;
};

/// Draw the outline of a box. @param far the edges at its back, else those at its front
void drawBox(const CairoCanvas& canvas, const Corners& box, const Camera& camera, bool far);

/// Draw ticks with numbers in world units along an edge of the box for each axis, outside its picture: as many as there
/// is room for.
/// @param lengthUnit of the world; empty: unknown  @param textSize [pixels]
void drawAxes(const CairoCanvas& canvas, Labels& labels, const Corners& box, const glm::dvec3& stretch,
              const std::string& lengthUnit, const Camera& camera, double textSize);

/// A mark on a scale.
struct Tick {
    double value;
    std::string text;
};
/// Marks at round numbers of an axis, about `wanted` of them; on a logarithmic one at powers of ten, or also at 2 and 5
/// times these, if its range holds a few.
[[nodiscard]] std::vector<Tick> ticks(const ScalarAxis& axis, int wanted);

} // namespace vdblic
