#include "vdblic/render/frame_renderer.h"

#include "vdblic/camera/affine_transform.h"
#include "vdblic/core/errors.h"
#include "vdblic/render/picture.h"
#include "vdblic/render/picture_share.h"
#include "vdblic/render/sequence_bounds.h"
#include "vdblic/render/solid_maker.h"

#include <fmt/format.h>
#include <glm/ext/matrix_transform.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <cstddef>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// A frame whose picture ranks share, and the leaves that this one reads.
struct FrameShare {
    PictureShare picture;
    ViewShare leaves;
};

/// @param header of the texture
FrameShare shareOf(const GridHeader& header, const Camera& camera, const glm::dvec3& stretch, Exchange& exchange)
{
    Corners box = cornersOf(header.box, *header.transform);
    for (glm::dvec3& corner : box)
        corner *= stretch;
    PictureShare picture{exchange, PictureCuts(camera, box, exchange.size())};
    const glm::dmat4 indexToWorld = glm::scale(glm::dmat4(1), stretch) * affineMatrix(*header.transform, "the texture");
    const ViewShare leaves(picture.cuts, exchange.rank(), indexToWorld);
    return {std::move(picture), leaves};
}

} // namespace

FrameImage FrameRenderer::render(std::shared_ptr<const LoadedTexture> loaded, RenderedFrame& frame) const
{
    const PicturePlan& plan = mPlan.picture;
    const FrameFile& file = frame.moment.file;
    const View* const view = frame.view;
    std::optional<FrameShare> share;
    if (view && !mExchange.isAlone()) {
        const std::optional<GridHeader> header = textureHeader(file, plan.texture);
        if (!header || !header->transform->isLinear()) {
            (void)loadFrame(plan, file); // says why
            throw InputError(fmt::format("{}: its header changes while it is read", file.path.string()));
        }
        share.emplace(shareOf(*header, view->cameras.at(double(file.frame)), plan.stretch, mExchange));
        loaded = nullptr;
    }
    if (!loaded) {
        loaded = std::make_shared<const LoadedTexture>(
            loadFrame(plan, frame.moment, view, share ? &share->leaves : nullptr));
    }
    frame.hasColor = loaded->hasColor;
    frame.unusableVoxels = loaded->unusable();
    if (!mPlan.outputs.histogram.empty() && view) {
        frame.histograms.emplace(view->look);
        loaded->addTo(*frame.histograms);
    }
    if (mPlan.outputs.images.empty() && mPlan.outputs.film.empty()) return {};
    const glm::ivec2 size = plan.size;
    FrameImage result;
    if (!view) {
        result.image = {size, std::vector<glm::vec4>(std::size_t(size.x) * std::size_t(size.y), glm::vec4(0))};
        if (plan.rays.layers) result.image.layers.resize(result.image.pixels.size());
        return result;
    }
    auto solid = view->solids->of(plan, *loaded);
    if (solid) frame.leftOut = solid->share;
    Picture picture(plan, *view,
                    std::make_shared<const ShownVolume>(plan, view->look, loaded, std::move(solid), mExchange,
                                                        view->lines ? &view->lines->look : nullptr),
                    share ? &share->picture : nullptr);
    for (int sample = 0; sample < plan.samples; ++sample) {
        mReporter.checkStop();
        picture.addSample();
    }
    result.image = picture.image();
    frame.nothingSeen = picture.whyNothingIsSeen(result.image);
    result.header = picture.header();
    if (share) {
        std::uint64_t unusable = frame.unusableVoxels;
        mExchange.sum({&unusable, 1});
        frame.unusableVoxels = unusable;
    }
    return result;
}

} // namespace vdblic
