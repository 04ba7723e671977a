#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/image/image.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/render/render_params.h"
#include "vdblic/render/scene.h"

#include <pybind11/pybind11.h>

#include <cstdint>
#include <optional>

namespace vdblic::python {

/// @param isSparse of the textures: they have another look where none is given  @throws ParameterError, InputError
[[nodiscard]] RenderParams renderParams(const pybind11::dict& keywords, bool isSparse);

/// Pictures of volumes in memory. As in vdblic_render of paths on standard input, the first volume with an active voxel
/// chooses camera and look for all. Not thread-safe.
class Picture {
  public:
    explicit Picture(const pybind11::dict& keywords)
        : mParams(renderParams(keywords, false)), mOfSparse(renderParams(keywords, true))
    {
    }

    /// @return linear light, premultiplied alpha: the background with its alpha behind, annotations over it
    [[nodiscard]] Image of(const VdbFile& volume, std::int64_t frame);
    /// Those of the volumes so far.
    [[nodiscard]] const RenderParams& params() const { return mParams; }

  private:
    RenderParams mParams;
    std::optional<RenderParams> mOfSparse; // until a volume has come
    std::optional<Scene> mScene;
    OneProcess mAlone;
};

} // namespace vdblic::python
