#include "vdblic/render/annotation_legend.h"

#include <cstddef>
#include <vector>

namespace vdblic {

double drawLegend(const CairoCanvas& canvas, const glm::dvec2& corner, double textSize, const std::string& title,
                  const TransferFunction& transfer, const glm::dvec3& ink)
{
    const std::vector<std::string>& kinds = transfer.params().kinds;
    const double side = 0.9 * textSize, line = 1.5 * textSize;
    canvas.drawText({corner.x, corner.y - 0.8 * textSize}, 1, title);
    double top = corner.y;
    for (std::size_t i = 1; i <= kinds.size(); ++i) {
        const std::size_t kind = i % kinds.size();
        canvas.setColor(transfer.displayColor(transfer.colorAxis().position(double(kind))));
        cairo_rectangle(canvas.context(), corner.x - side, top, side, side);
        cairo_fill(canvas.context());
        canvas.setColor(ink);
        cairo_rectangle(canvas.context(), corner.x - side, top, side, side);
        cairo_stroke(canvas.context());
        canvas.drawText({corner.x - side - 0.5 * textSize, top + 0.8 * textSize}, 1, kinds[kind]);
        top += line;
    }
    return top - line + side;
}

} // namespace vdblic
