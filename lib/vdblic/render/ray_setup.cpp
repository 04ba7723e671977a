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
    const glm::dvec3 first(visible.first()[0], visible.first()[1], visible.first()[2]);
    mLow = volume.low() - first;
    mHigh = volume.high() - first;
    const glm::dmat3 gradients = glm::transpose(glm::dmat3(volume.worldToIndex())); // of the index, by axis
    for (int axis = 0; axis < 3; ++axis)
        mAlong[axis] = glm::normalize(gradients[axis]);
    for (const ClipPlane& plane : params.clip.allPlanes())
        mCuts.push_back({plane, -glm::normalize(plane.normal)});
}

RayTask RaySetup::ray(int x, int y) const
{
    const Ray ray = mCamera.ray({x + 0.5, y + 0.5});
    const glm::dmat3 toIndex(mToIndex);
    const glm::dvec3 origin = toIndex * ray.origin + glm::dvec3(mToIndex[3]), perWorld = toIndex * ray.direction;
    const double voxelsPerWorld = glm::length(perWorld);
    RayTask task{};
    RayInterval interval;
    int entered = -1; // the axis across which the ray comes in
    for (int axis = 0; axis < 3; ++axis) {
        constexpr double kTiny = 1e-12; // in place of 0, so that no face is ever reached
        const double direction = perWorld[axis] / voxelsPerWorld;
        const double inverse = 1 / (std::abs(direction) > kTiny ? direction : kTiny);
        const double low = (mLow[axis] - origin[axis]) * inverse, high = (mHigh[axis] - origin[axis]) * inverse;
        const double enter = std::min(low, high);
        entered = enter > interval.enter ? axis : entered;
        interval.enter = std::max(interval.enter, enter);
        interval.leave = std::min(interval.leave, std::max(low, high));
        task.direction[axis] = float(direction);
        task.inverse[axis] = float(inverse);
        task.shading[kViewX + axis] = float(ray.direction[axis]);
    }
    if (interval.empty()) return task;
    interval.enter /= voxelsPerWorld;
    interval.leave /= voxelsPerWorld;
    if (entered >= 0) interval.entryNormal = perWorld[entered] > 0 ? -mAlong[entered] : mAlong[entered];
    for (const Cut& cut : mCuts)
        interval.clip(ray.origin, ray.direction, cut.plane, cut.outward);
    if (interval.empty()) return task;

    task.pixel = y * mCamera.size().x + x;
    const double stepsPerWorld = voxelsPerWorld / mStep;
    const double span = (interval.leave - interval.enter) * stepsPerWorld;
    const double start = double(sampleShift(x, y, mRay)) - interval.enter * stepsPerWorld;
    task.shift = float(start - std::floor(start));
    task.span = float(span);
    task.samples = std::max(int(std::ceil(span - double(task.shift))), 0) + 1;
    for (int axis = 0; axis < 3; ++axis)
        task.entry[axis] = float(origin[axis] + perWorld[axis] * interval.enter);
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
