#include "vdblic/render/frame_picture.h"

#include "vdblic/image/color_map.h"
#include "vdblic/render/annotations.h"
#include "vdblic/render/image_attributes.h"
#include "vdblic/render/nothing_seen.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <utility>

namespace vdblic {

FramePicture::FramePicture(const RenderParams& params, const Scene& scene, const LoadedTexture& frame,
                           std::shared_ptr<const Solid> solid, const PictureShare* share)
    : mParams(params), mScene(scene), mFrame(frame), mSolid(std::move(solid)), mShare(share),
      mExchange(share ? share->exchange : mAlone), mRays(params.rays), mCamera(scene.cameras.at(frame.file.frame))
{
    mRays.clip = params.rays.clip.stretched(params.stretch);
    const Look& look = scene.look;
    if (look.shadows > 0)
        mLight.emplace(frame.volume, look, keyLight(look, mCamera), double(look.shadows), mSolid.get(), mExchange);
    const Scenery scenery{.solid = mSolid.get(),
                          .solidColor = glm::vec3(linearFromDisplay(params.solid.color)),
                          .light = mLight ? &*mLight : nullptr};
    mSum.emplace(frame.volume, look, share ? mCamera.cropped(share->area()) : mCamera, mRays, scenery);
}

Image FramePicture::image() const
{
    Image image = mSum->mean();
    if (mShare) mShare->assemble(image);
    if (mParams.annotations.any() && mExchange.isFirst()) {
        const AnnotationContent content{mScene.box,       mParams.stretch,    mParams.colorBy,
                                        mScene.opacityBy, mFrame.file.frame,  mFrame.clock,
                                        mFrame.colorUnit, mFrame.opacityUnit, mFrame.lengthUnit};
        annotate(image, mParams.annotations, content, mScene.look, mCamera, mParams.background.color);
    }
    return image;
}

ImageHeader FramePicture::header() const
{
    return imageHeader(mParams, mScene.look, mCamera, mFrame.file);
}

std::string FramePicture::whyNothingIsSeen(const Image& image)
{
    const auto isSeen = [](const glm::vec4& pixel) { return pixel.a > 0; };
    const bool anySeen = std::any_of(image.pixels.begin(), image.pixels.end(), isSeen);
    if (mExchange.any(anySeen)) return {};
    return vdblic::whyNothingIsSeen(mFrame.volume, mScene.look, mCamera, mRays, mExchange);
}

} // namespace vdblic
