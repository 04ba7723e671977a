#include "vdblic/render/image_attributes.h"

namespace vdblic {

ImageHeader imageHeader(const RenderParams& params, const Look& look, const Camera& camera, const FrameFile& file)
{
    ImageHeader header;
    header.worldToCamera = camera.worldToCamera();
    header.worldToNdc = camera.worldToNdc();
    header.screenWindowWidth = float(2 * camera.halfExtent().x);
    header.attributes = {
        {"frame", int(file.frame)},
        {"source", file.path.filename().string()},
        {"textureGrid", params.texture},
        {"projection", std::string(toString(camera.projection()))},
        {"eye", glm::vec3(camera.eye())},
        {"target", glm::vec3(camera.target())},
        {"up", glm::vec3(camera.up())},
        {"samples", params.samples},
        {"step", float(params.rays.step)},
        {"leastTransmittance", float(params.rays.leastTransmittance)},
        {"colorMap", look.transfer.colorMapName()},
        {"opacity", opacityText(look.transfer.opacity())},
        {"magnitudeRange", glm::vec2(look.transfer.range()[0], look.transfer.range()[1])},
        {"textureRange", glm::vec2(look.texture.low, look.texture.high)},
        {"textureStrength", look.texture.strength},
        {"ambient", look.shading.ambient},
        {"diffuse", look.shading.diffuse},
        {"specular", look.shading.specular},
        {"shininess", look.shading.shininess},
        {"leastGradient", look.shading.leastGradient},
        {"backgroundColor", glm::vec3(params.background.color)},
        {"backgroundAlpha", float(params.background.alpha)},
    };
    if (camera.projection() == Projection::kPerspective) {
        header.attributes.emplace_back("fieldOfView", float(camera.fieldOfView()));
    } else {
        header.attributes.emplace_back("viewHeight", float(2 * camera.halfExtent().y));
    }
    if (params.motion.orbit != 0) header.attributes.emplace_back("orbit", float(params.motion.orbit));
    if (!params.motion.keys.empty()) {
        header.attributes.emplace_back("cameraKeys", params.motion.keys.filename().string());
    }
    return header;
}

} // namespace vdblic
