#pragma once

#include "vdblic/methods/flow_texture.h"
#include "vdblic/methods/streaks/streak.h"
#include "vdblic/methods/streaks/streak_params.h"
#include "vdblic/methods/streaks/streak_shape.h"
#include "vdblic/methods/texture_params.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

/// Sparse textures whose streaks show where the flow goes and move with it (docs/methods.md).
///
/// Liu & Moorhead (2004, section 3.1) explain why sparse noise cannot be fed to AUFLIC: empty space, fed forward, does
/// not follow the flow. Nothing is fed forward here. A sparse set of particles lives for many frames, a controller
/// keeps them a spacing apart, and each texture shows the recent part of their pathlines. Particles are traced through
/// a whole frame at once: substeps only draw them more often.
///
/// Each of several ranks has all streaks; it advances and draws those, or their parts, in its own leaves.
class StreakTexture final : public FlowTexture, public TextureMemory, public AdaptiveTexture {
  public:
    /// @param refinement as given
    StreakTexture(const TextureParams& texture, StreakParams params, const Refinement& refinement, std::uint32_t seed);

    [[nodiscard]] std::string choose(const Domain& velocity, double displacement) override;
    [[nodiscard]] TextureFrame advance(const FlowStep& step) override;
    [[nodiscard]] Lengths<Space::kTexture> farthestPath(const Speeds<Space::kTexture, Per::kFrame>& fastest,
                                                        double seconds) const override;

    /// One, of the rank that has the domain's first leaf.
    [[nodiscard]] std::size_t parts() const override { return mIsSaver ? 1 : 0; }
    [[nodiscard]] Saved save(std::size_t part) const override;
    void restore(std::uint64_t steps, double seconds, std::shared_ptr<const Domain> domain,
                 const std::function<std::optional<VdbFile>()>& next) override;

  private:
    void traceFrame(const FlowStep& flow, const LeafOwners& owners, TextureFrame& result, StageClock& clock);
    [[nodiscard]] std::shared_ptr<const Domain> emittingPart(const VelocityFrame& frame, std::int64_t number) const;
    void markSources(const VelocityFrame& frame, std::int64_t number);
    void forgetPast(double time);
    void sortByPlace();

    TextureParams mTexture;
    StreakParams mParams;
    Refinement mGiven;
    std::uint32_t mSeed;
    StreakShape mShape;
    std::vector<Streak> mStreaks;
    bool mHasBegun = false; // whether the first streaks are there
    bool mIsSaver = true;
    double mLastInterval = 0; // seconds
    std::uint64_t mStep = 0;
};

} // namespace vdblic
