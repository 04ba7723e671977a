#include "renderer.h"

#include "options.h"

#include "vdblic/io/texture_name.h"
#include "vdblic/render/picture.h"
#include "vdblic/render/solid_maker.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::python {

Renderer::Renderer(const pybind11::dict& keywords)
{
    PictureParams params;
    setFrom(keywords, parametersOf(params));
    mPlan = resolve(params, {.isSparse = false});
    mOfSparse = resolve(params, {.isSparse = true});
}

Image Renderer::of(const VdbFile& volume, std::int64_t frame)
{
    if (mOfSparse && isSparse(volume.metadata)) mPlan = std::move(*mOfSparse);
    mOfSparse.reset();
    const PicturePlan& plan = mPlan;
    const auto loaded =
        std::make_shared<const LoadedTexture>(loadFrame(plan, volume, {frame, volume.path}, mView ? &*mView : nullptr));
    if (!mView) {
        const glm::ivec2 size = plan.size;
        if (loaded->empty())
            return {size, pixelsOver({size, std::vector<glm::vec4>(std::size_t(size.x) * size.y)}, plan.background)};
        mView = chooseView(plan, {&loaded, 1}, loaded->box().corners(), {}, mAlone);
    }
    Picture picture(plan, *mView,
                    std::make_shared<const ShownVolume>(plan, mView->look, loaded, mView->solids->of(plan, *loaded),
                                                        mAlone, mView->lines ? &mView->lines->look : nullptr));
    for (int sample = 0; sample < plan.samples; ++sample)
        picture.addSample();
    Image image = picture.image();
    image.pixels = pixelsOver(image, plan.background);
    for (std::size_t i = 0; i < image.annotations.size(); ++i)
        image.pixels[i] = image.annotations[i] + image.pixels[i] * (1 - image.annotations[i].a);
    return image;
}

} // namespace vdblic::python
