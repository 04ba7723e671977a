#pragma once

#include "vdblic/render/sample_shader.h"

namespace vdblic {

/// Traces rays, eight in flight: a lane whose ray is done takes the next, so that lanes never idle in empty space.
///
/// A sample costs little until it is known to be seen; those that are wait in a queue to be shaded eight at a time.
class RayKernel {
  public:
    RayKernel(const TextureVolume& volume, const Look& look, const RayCastParams& params, const VisibleLeaves& visible,
              const SampleShader& shader);

    /// @param sums receives what each task's ray adds up to; count of them, all zero
    void trace(const RayTask* tasks, int count, RaySum* sums) const;

  private:
    struct Lanes;
    struct Sample;

    void load(const RayTask& ray, int task, Lanes& lanes, int lane) const;
    void park(Lanes& lanes, int lane) const;
    Int8 isOver(const Lanes& lanes) const;
    void place(const Lanes& lanes, Sample& result) const;
    unsigned leaving(const Lanes& lanes, const Sample& sample) const;
    void skip(Lanes& lanes, const Sample& sample, unsigned which) const;
    void interpolate(Sample& result) const;
    void absorb(Lanes& lanes, const Sample& sample, ShadeQueue& queue) const;
    // What is seldom needed is called, not merged into the loop, which then has less to keep in registers.
    [[gnu::noinline]] void advance(const RayTask* tasks, int count, int& next, unsigned leaving, Lanes& lanes,
                                   Sample& sample, RaySum* sums) const;
    [[gnu::noinline]] unsigned findHidden(unsigned lanes, const Sample& sample) const;
    [[gnu::noinline]] void findFlanks(const Sample& sample, const Float8* view, Float8& result) const;

    const TextureVolume& mVolume;
    const Look& mLook;
    const VisibleLeaves& mVisible;
    const SampleShader& mShader;
    float mStep, mPerStep, mLeastTransmittance, mMargin;
    std::vector<float> mPowers; // of 2: what a step at full density lets through, by the transfer function's entries
};

} // namespace vdblic
