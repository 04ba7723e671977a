#pragma once

#include "vdblic/cast/solid.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace vdblic {

struct LoadedTexture;
struct PicturePlan;

/// Makes the solids of frames and keeps the last one: a constant solid is made once. Thread-safe.
class SolidMaker {
  public:
    /// The solid of a frame; null if the plan has none. @throws InputError of makeSolid()
    [[nodiscard]] std::shared_ptr<const Solid> of(const PicturePlan& plan, const LoadedTexture& frame);

  private:
    /// What a solid is made of.
    struct Key {
        std::string source;
        bool earth;
        glm::dvec3 stretch;
        std::optional<std::int64_t> frame; // of solids that change
        double voxel;                      // of the texture: a coarser copy has another solid
        bool operator==(const Key&) const = default;
    };
    std::mutex mMutex;
    Key mKey{};
    std::shared_ptr<const Solid> mSolid;
};

} // namespace vdblic
