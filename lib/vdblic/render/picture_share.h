#pragma once

#include "vdblic/cast/picture_cuts.h"
#include "vdblic/core/exchange.h"
#include "vdblic/image/image.h"

namespace vdblic {

/// A picture whose parts several ranks cast.
struct PictureShare {
    Exchange& exchange;
    PictureCuts cuts;

    [[nodiscard]] const PictureArea& area() const { return cuts.area(exchange.rank()); }
    /// Give rank 0 the parts of the others. Collective. @param image of the whole size, with the part of this rank
    void assemble(Image& image) const;
};

} // namespace vdblic
