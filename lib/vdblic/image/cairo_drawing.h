#pragma once

#include <cairo/cairo.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <memory>
#include <string>

namespace vdblic {

/// A picture in memory to draw on with Cairo; positions are in pixels from the top left corner.
class CairoCanvas {
  public:
    CairoCanvas(cairo_format_t format, const glm::ivec2& size);

    [[nodiscard]] cairo_t* context() const { return mContext.get(); }
    [[nodiscard]] cairo_surface_t* surface() const { return mSurface.get(); }

    void setColor(const glm::dvec3& color, double alpha = 1) const;
    void drawLine(const glm::dvec2& from, const glm::dvec2& to) const;
    /// @param point  on the baseline
    /// @param anchor place of the point in the text: 0 begin, ½ middle, 1 end
    void drawText(const glm::dvec2& point, double anchor, const std::string& text) const;

  private:
    std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> mSurface;
    std::unique_ptr<cairo_t, decltype(&cairo_destroy)> mContext;
};

} // namespace vdblic
