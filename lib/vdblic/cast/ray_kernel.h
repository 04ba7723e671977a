#pragma once

#include "vdblic/cast/lanes.h"
#include "vdblic/cast/ray_task.h"
#include "vdblic/volume/record_sampling.h"
#include "vdblic/volume/visible_space.h"

#include <vector>

namespace vdblic {

class SampleShader;
class ShadeQueue;
class TextureVolume;
struct Look;
struct RayCastParams;

/// Traces rays, eight at a time: a lane whose ray ends takes the next ray, so that no lane idles.
///
/// A sample's opacity comes first. Only a visible sample enters a queue, from which eight at a time are shaded.
/// Thread-safe.
class RayKernel {
  public:
    RayKernel(const TextureVolume& volume, const Look& look, const RayCastParams& params, const VisibleSpace& visible,
              const SampleShader& shader);

    /// @param tasks, sums `count` of each; each ray is added to its sum, all zero before
    void trace(const RayTask* tasks, int count, RaySum* sums) const;

  private:
    struct Lanes;
    struct Sample;

    void load(const RayTask& ray, int task, Lanes& lanes, int lane) const;
    void park(Lanes& lanes, int lane) const;
    Int8 isOver(const Lanes& lanes) const;
    void locate(const Lanes& lanes, Sample& result) const;
    void findEmpty(const Lanes& lanes, Sample& result) const;
    unsigned leaving(const Lanes& lanes, const Sample& sample) const;
    void skip(Lanes& lanes, const Sample& sample, unsigned which) const;
    void interpolate(Sample& result, unsigned which) const;
    void absorb(Lanes& lanes, Int8 which, const Sample& sample, ShadeQueue& queue) const;
    // Rarely needed. Inlined, they would take registers from the loop.
    [[gnu::noinline]] void advance(const RayTask* tasks, int count, int& next, unsigned leaving, Lanes& lanes,
                                   Sample& sample, RaySum* sums) const;
    [[gnu::noinline]] void interpolateCubic(Sample& result, unsigned which) const;
    [[gnu::noinline]] void skipLeaves(const Lanes& lanes, const Sample& sample, Int8& next) const;
    [[gnu::noinline]] unsigned findHidden(unsigned lanes, const Sample& sample) const;
    void findFlanks(const Sample& sample, const Float8* view, Float8& result) const;

    const TextureVolume& mVolume;
    TextureSampler mTexture;
    const Look& mLook;
    const VisibleSpace& mVisible;
    const SampleShader& mShader;
    float mStep, mPerStep, mLeastTransmittance, mMargin;
    float mHidden; // largest stretched texture without opacity
    bool mIsCubic;
    std::vector<float> mPowers; // of 2: transmittance of a step at full density, by entry of the transfer function
};

} // namespace vdblic
