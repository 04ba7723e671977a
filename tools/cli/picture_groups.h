#pragma once

#include "cli/parameter_options.h"

namespace vdblic::cli {

/// Where the help shows the input and the parameters of a picture. @param further groups behind that of the input
inline std::vector<OptionGroup> pictureGroups(const std::vector<OptionGroup>& further = {})
{
    std::vector<OptionGroup> groups = {
        {"Input", {"frames", "clamp_frames", "renumber"}},
        {"Picture",
         {"look", "texture", "size", "samples", "step", "interpolation", "annotate", "background", "background_top",
          "background_alpha"}},
        {"Camera",
         {"stretch", "view", "angles", "view_from", "eye", "target", "up", "projection", "fov", "view_height",
          "aperture", "orbit", "orbit_frames", "camera"}},
        {"Colour and opacity",
         {"by", "color_by", "opacity_by", "transfer", "colormap", "colors", "opacity", "range", "opacity_range",
          "color_scale", "opacity_scale", "modulate", "limb_darkening"}},
        {"Light", {"shading", "head_light", "light", "halo", "shadows", "occlusion", "depth_cue", "exposure"}},
        {"Cuts", {"clip_plane", "clip_box", "roi", "roi_box"}},
        {"Solid", {"solid", "solid_color", "earth", "ground"}},
    };
    groups.insert(groups.begin() + 1, further.begin(), further.end());
    return groups;
}

} // namespace vdblic::cli
