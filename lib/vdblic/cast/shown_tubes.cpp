#include "vdblic/cast/shown_tubes.h"

#include <algorithm>

namespace vdblic {

ShownTubes::ShownTubes(const Tubes& tubes, const Look& look)
    : mTubes(tubes), mTransfer(look.transfer), mTexture(look.texture), mHalo(look.halo)
{
    for (std::uint32_t number = 0; number < tubes.cones().size(); ++number) {
        const std::uint32_t first = tubes.cones()[number].first;
        const float a = Tubes::valueAt(tubes.drivers(), first, 0), b = Tubes::valueAt(tubes.drivers(), first, 1);
        const bool isOpaque = tubes.opacities()[first] > 0 || tubes.opacities()[first + 1] > 0;
        if (isOpaque && mTransfer.contributes(std::min(a, b), std::max(a, b))) mCones.push_back(number);
    }
}

} // namespace vdblic
