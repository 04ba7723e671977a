#pragma once

#include "vdblic/core/names.h"

namespace vdblic {

/// How the texture of a frame is made.
enum class TextureMethod {
    kAuflic,     ///< accelerated UFLIC, with history (docs/algorithm.md)
    kAuflic2004, ///< accelerated UFLIC as published (Liu & Moorhead 2004)
    kUflic,      ///< a seed for every voxel and frame (Shen & Kao 1998)
    kLic,        ///< each frame on its own (Cabral & Leedom 1993)
    kStreaks,    ///< sparse: particles that live for many frames, with tails (docs/methods.md)
    kIbfv,       ///< the texture before, pulled back and blended with noise (van Wijk 2002)
    kLea,        ///< moved noise, blended from frame to frame (Jobard, Erlebacher & Hussaini 2002)
    kUfac,       ///< moved noise, convolved along streamlines (Weiskopf, Erlebacher & Ertl 2003)
};
template<>
inline constexpr auto kNames<TextureMethod> = std::to_array<std::string_view>({"auflic", "auflic-2004", "uflic", "lic",
                                                                               "streaks", "ibfv", "lea", "ufac"});

/// Whether a texture is of its frame alone, and not of those before.
[[nodiscard]] constexpr bool isSteady(TextureMethod method)
{
    return method == TextureMethod::kLic;
}

/// Whether values come back along pathlines, and are not scattered along them (docs/methods.md).
[[nodiscard]] constexpr bool looksBack(TextureMethod method)
{
    return method == TextureMethod::kIbfv || method == TextureMethod::kLea || method == TextureMethod::kUfac;
}

/// Whether values are scattered along pathlines, so that voxels collect hits.
[[nodiscard]] constexpr bool scatters(TextureMethod method)
{
    return method == TextureMethod::kAuflic || method == TextureMethod::kAuflic2004 || method == TextureMethod::kUflic;
}

/// Whether textures are blended from frame to frame, with a share of the new one.
[[nodiscard]] constexpr bool blends(TextureMethod method)
{
    return method == TextureMethod::kIbfv || method == TextureMethod::kLea;
}

} // namespace vdblic
