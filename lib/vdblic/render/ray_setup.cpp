#include "vdblic/render/ray_setup.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <cmath>

namespace vdblic {

RaySetup::RaySetup(const TextureVolume& volume, const VisibleLeaves& visible, const Camera& camera,
                   const RayCastParams& params, const SampleShader& shader, int ray)
    : mCamera(camera), mShader(shader), mStep(params.step), mRay(ray), mToIndex(volume.worldToIndex())
{
    for (int axis = 0; axis < 3; ++axis)
        mToIndex[3][axis] -= visible.first()[axis];
    const Corners corners = volume.corners();
    const glm::dmat3 gradients = glm::transpose(glm::dmat3(volume.worldToIndex())); // of the index, by axis
    std::vector<ClipPlane> planes; // the volume's own first: most rays that miss do so there
    for (int axis = 0; axis < 3; ++axis) {
        planes.push_back({corners.front(), gradients[axis]});
        planes.push_back({corners.back(), -gradients[axis]});
    }
    const std::vector<ClipPlane> cuts = params.clip.allPlanes();
    planes.insert(planes.end(), cuts.begin(), cuts.end());
    for (const ClipPlane& plane : planes)
        mFaces.push_back({plane, -glm::normalize(plane.normal)});
}

RayTask RaySetup::ray(int x, int y) const
{
    const Ray ray = mCamera.ray({x + 0.5, y + 0.5});
    RayInterval interval;
    RayTask task{};
    for (const auto& [plane, outward] : mFaces) {
        interval.clip(ray.origin, ray.direction, plane, outward);
        if (interval.empty()) return task;
    }
    task.pixel = y * mCamera.size().x + x;
    const glm::dvec3 origin(mToIndex * glm::dvec4(ray.origin, 1));
    const glm::dvec3 perWorld = glm::dmat3(mToIndex) * ray.direction;
    const double stepsPerWorld = glm::length(perWorld) / mStep;
    const double span = (interval.leave - interval.enter) * stepsPerWorld;
    const double start = double(sampleShift(x, y, mRay)) - interval.enter * stepsPerWorld;
    task.shift = float(start - std::floor(start));
    task.span = float(span);
    task.samples = std::max(int(std::ceil(span - double(task.shift))), 0) + 1;
    for (int axis = 0; axis < 3; ++axis) {
        constexpr double kTiny = 1e-12; // in place of 0, so that no face is ever reached
        const double direction = perWorld[axis] / (stepsPerWorld * mStep);
        task.entry[axis] = float(origin[axis] + perWorld[axis] * interval.enter);
        task.direction[axis] = float(direction);
        task.inverse[axis] = float(1 / (std::abs(direction) > kTiny ? direction : kTiny));
        task.shading[kViewX + axis] = float(ray.direction[axis]);
    }
    const double depthPerWorld = (mCamera.worldToCamera() * glm::dvec4(ray.direction, 0)).z;
    const double originDepth = (mCamera.worldToCamera() * glm::dvec4(ray.origin, 1)).z;
    task.shading[kEntryDepth] = float(originDepth + interval.enter * depthPerWorld);
    task.shading[kDepthPerStep] = float(depthPerWorld / stepsPerWorld);
    task.shading[kFaceLit] = -1;
    if (interval.entryNormal) {
        const SampleShader::FaceLight face = mShader.lightFace(*interval.entryNormal, ray.direction);
        task.shading[kFaceLit] = face.lit;
        task.shading[kFaceWhite] = face.white;
    }
    return task;
}

} // namespace vdblic
