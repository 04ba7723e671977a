#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/image/image.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/view.h"

#include <pybind11/pybind11.h>

#include <cstdint>
#include <optional>

namespace vdblic::python {

/// Pictures of volumes in memory. As in vdblic_render of paths on standard input, the first volume with an active voxel
/// chooses camera and look for all. Not thread-safe.
class Renderer {
  public:
    /// @throws ParameterError, InputError
    explicit Renderer(const pybind11::dict& keywords);

    /// @return linear light, premultiplied alpha: the background with its alpha behind, annotations over it
    [[nodiscard]] Image of(const VdbFile& volume, std::int64_t frame);
    /// The plan for the volumes so far.
    [[nodiscard]] const PicturePlan& plan() const { return mPlan; }

  private:
    PicturePlan mPlan;
    std::optional<PicturePlan> mOfSparse; // until a volume has come
    std::optional<View> mView;
    OneProcess mAlone;
};

} // namespace vdblic::python
