#pragma once

#include "vdblic/cast/tubes.h"
#include "vdblic/volume/placed_box.h"

#include <cstddef>
#include <string>

namespace vdblic::view {

/// The lines of a frame for a browser to draw, as little-endian columns.
///
/// First a number, 4 bytes, that tells the length of the JSON after it, {"points", "lines", "part", "low", "high",
/// "radius", "hasColor"}, spaces at its end included. Then
///
///     points × f32    the scalar that opacity follows, NaN for none; with `hasColor` as many of the one of colour
///     lines × u32     ids;  lines × u32   numbers of points
///     points × u16    x; y; z: shares of 65535 from `low` to `high`, in the picture's world
///     points × u16    place along the line, rising to its head, 65534 there
///     lines × u16     opacity of the head, shares of 65535
///
/// @param box  in the picture's world, which `low` to `high` holds beside the lines
/// @param most points: of more, lines are left out whose id is no multiple of `part`, a power of two
/// `radius` is the greatest one of a tube. Lines of which a part is left out come as several.
[[nodiscard]] std::string linePacket(const Tubes& tubes, const Corners& box, std::size_t most);

} // namespace vdblic::view
