#include "picture.h"

#include "options.h"

#include "vdblic/io/texture_name.h"
#include "vdblic/render/frame_picture.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::python {
RenderParams renderParams(const pybind11::dict& keywords, bool isSparse)
{
    RenderParams params = defaultRenderParams(isSparse);
    setFrom(keywords, pictureParametersOf(params));
    params.output = "picture.exr"; // which is not written
    params.input.pattern = "-";
    params.validate();
    return params;
}

Image Picture::of(const VdbFile& volume, std::int64_t frame)
{
    if (mOfSparse && isSparse(volume.metadata)) mParams = *mOfSparse;
    mOfSparse.reset();
    const RenderParams& params = mParams;
    const auto loaded = std::make_shared<const LoadedTexture>(
        loadFrame(params, volume, {frame, volume.path}, mScene ? &*mScene : nullptr));
    if (!mScene) {
        const glm::ivec2 size = params.scaledSize();
        if (loaded->volume.empty())
            return {size, pixelsOver({size, std::vector<glm::vec4>(std::size_t(size.x) * size.y)}, params.background)};
        mScene = chooseScene(params, {&loaded, 1}, loaded->volume.corners(), {}, mAlone);
    }
    std::shared_ptr<const Solid> solid;
    if (!params.solid.source.empty())
        solid = std::make_shared<const Solid>(makeSolid(params.solid, *loaded->domain(), params.stretch, frame));
    FramePicture picture(params, *mScene,
                         std::make_shared<const ShownFrame>(params, mScene->look, loaded, std::move(solid), mAlone));
    for (int sample = 0; sample < params.samples; ++sample)
        picture.addSample();
    Image image = picture.image();
    image.pixels = pixelsOver(image, params.background);
    for (std::size_t i = 0; i < image.annotations.size(); ++i)
        image.pixels[i] = image.annotations[i] + image.pixels[i] * (1 - image.annotations[i].a);
    return image;
}

} // namespace vdblic::python
