#include "vdblic/render/picture.h"

#include "vdblic/cast/ground_plane.h"
#include "vdblic/image/color_map.h"
#include "vdblic/image/tone.h"
#include "vdblic/render/annotations.h"
#include "vdblic/render/image_attributes.h"
#include "vdblic/render/nothing_seen.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <utility>

namespace vdblic {

namespace {

/// Cubic where linear interpolation would be seen as a pattern of voxels. One choice for all frames of a film.
Interpolation interpolationFor(const View& view, const TextureVolume& volume)
{
    constexpr double kWidePixels = 3;
    const double pixel = view.cameras.first().pixelSize(middleOf(view.box));
    return volume.voxelSize() > kWidePixels * pixel ? Interpolation::kCubic : Interpolation::kLinear;
}

} // namespace

Picture::Picture(const PicturePlan& plan, const View& view, std::shared_ptr<const ShownVolume> shown,
                 const PictureShare* share)
    : mPlan(plan), mView(view), mShown(std::move(shown)), mShare(share), mExchange(share ? share->exchange : mAlone),
      mRays(plan.rays), mCamera(view.cameras.at(mShown->frame().file.frame))
{
    mRays.clip = plan.rays.clip.stretched(plan.stretch);
    if (!mRays.interpolation) mRays.interpolation = interpolationFor(view, mShown->volume());
    const Look& look = view.look;
    const TextureVolume& volume = mShown->volume();
    const Solid* const solid = mShown->solid();
    const glm::dvec3 light = keyLight(look, mCamera);
    if (mShown->ambient()) mLight.emplace(*mShown->extinctions(), *mShown->ambient(), volume, look, light);
    if (plan.ground.side != GroundSide::kNone) {
        const std::vector<ClipPlane> cuts = mRays.clip.allPlanes(), solidCuts = mRays.clip.solidPlanes();
        // Automatic cameras may look along up and then have another one.
        const glm::dvec3 up = plan.motion.keys.empty() ? plan.camera.up.value_or(glm::dvec3(0, 0, 1)) : mCamera.up();
        const GroundPlane plane = groundPlane(plan.ground.side, up, view.box, solid);
        std::optional<glm::vec3> color;
        if (plan.ground.color) color = glm::vec3(linearFromDisplay(*plan.ground.color));
        mGround.emplace(plane, ShadowCasters{*mShown->extinctions(), volume, cuts, solid, solidCuts}, light, color);
    }
    const Scenery scenery{.solid = solid,
                          .solidColor = glm::vec3(linearFromDisplay(plan.solid.color)),
                          .light = mLight ? &*mLight : nullptr,
                          .ground = mGround ? &*mGround : nullptr};
    mSum.emplace(volume, look, mShown->visible(), share ? mCamera.cropped(share->area()) : mCamera, mRays, scenery);
}

Image Picture::image() const
{
    const LoadedTexture& frame = mShown->frame();
    Image image = exposed(mSum->mean(), mView.look.exposure);
    if (mShare) mShare->assemble(image);
    if (mPlan.annotations.any() && mExchange.isFirst()) {
        const auto shown = [&](const std::string& name) { // the texture stands in for the speed
            return !frame.hasColor && name == mPlan.colorBy ? frame.texture->getName() : name;
        };
        FrameClock clock = frame.clock;
        clock.longest = mView.longest;
        const AnnotationContent content{mView.box,
                                        mPlan.stretch,
                                        shown(mPlan.colorBy),
                                        shown(mView.opacityBy),
                                        frame.file.frame,
                                        clock,
                                        mView.lastFrame,
                                        frame.colorUnit,
                                        frame.opacityUnit,
                                        frame.lengthUnit,
                                        isGeographic(clock, frame.lengthUnit, mPlan.stretch)};
        annotate(image, mPlan.annotations, content, mView.look, mCamera, mPlan.background.at(0.5));
    }
    return image;
}

ImageHeader Picture::header() const
{
    PicturePlan plan = mPlan;
    plan.texture = mShown->frame().texture->getName();
    if (!plan.opacityBy.empty()) plan.opacityBy = {mView.opacityBy};
    plan.rays.interpolation = mRays.interpolation;
    return imageHeader(plan, mView.look, mCamera, mShown->frame().file);
}

std::string Picture::whyNothingIsSeen(const Image& image)
{
    const auto isSeen = [](const glm::vec4& pixel) { return pixel.a > 0; };
    const bool anySeen = std::any_of(image.pixels.begin(), image.pixels.end(), isSeen);
    if (mExchange.any(anySeen)) return {};
    return vdblic::whyNothingIsSeen(mShown->volume(), mView.look, mCamera, mRays, mExchange);
}

} // namespace vdblic
