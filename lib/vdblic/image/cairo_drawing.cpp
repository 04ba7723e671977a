#include "vdblic/image/cairo_drawing.h"

namespace vdblic {

CairoCanvas::CairoCanvas(cairo_format_t format, const glm::ivec2& size)
    : mSurface(cairo_image_surface_create(format, size.x, size.y), cairo_surface_destroy),
      mContext(cairo_create(mSurface.get()), cairo_destroy)
{
    cairo_set_line_cap(context(), CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(context(), CAIRO_LINE_JOIN_ROUND);
}

void CairoCanvas::setColor(const glm::dvec3& color, double alpha) const
{
    cairo_set_source_rgba(context(), color.r, color.g, color.b, alpha);
}

void CairoCanvas::drawLine(const glm::dvec2& from, const glm::dvec2& to) const
{
    cairo_move_to(context(), from.x, from.y);
    cairo_line_to(context(), to.x, to.y);
    cairo_stroke(context());
}

void CairoCanvas::drawText(const glm::dvec2& point, double anchor, const std::string& text) const
{
    cairo_text_extents_t extents;
    cairo_text_extents(context(), text.c_str(), &extents);
    cairo_move_to(context(), point.x - anchor * extents.x_advance, point.y);
    cairo_show_text(context(), text.c_str());
    cairo_new_path(context()); // text leaves a current point
}

} // namespace vdblic
