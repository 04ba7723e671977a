#pragma once

#include "vdblic/field/frame_domain.h"
#include "vdblic/noise/noise_field.h"

#include <openvdb/openvdb.h>

#include <cstdint>
#include <memory>
#include <string_view>

namespace vdblic {

class FlowTexture;
struct MethodParams;
struct ScatterMethod;

/// What textures are made from beside the flow and the parameters of their method.
struct MethodInput {
    NoiseField noise;
    std::uint32_t seed = 1;  ///< of the noise
    Refinement refinement{}; ///< as given
};

/// A method, as the rest of the library knows it. Each is described in its own folder, under its paper, and listed in
/// `registry.cpp`; nothing else names all of them (docs/architecture.md).
struct TextureMethod {
    std::string_view name; ///< as the parameter `method`, texture files and reports spell it
    std::string_view text; ///< what it does, for the help

    bool isSteady = false; ///< whether a texture is of its frame alone, and not of those before
    bool isSparse = false; ///< whether textures are drawn into voxels of their own, and not on refined ones of the flow
    bool blends = false;   ///< whether a share of new noise is blended in with every frame (BackwardParams::alpha)
    const ScatterMethod* scatter = nullptr; ///< how values are scattered along pathlines, so that voxels collect hits

    int finish = 0; ///< default of FinishParams::taps
    /// Default of the frames that the first one stands still for.
    int (*preroll)(const MethodParams& params);
    /// Default of the frames on disk that are computed before the selected ones.
    int (*leadIn)(const MethodParams& params);

    std::unique_ptr<FlowTexture> (*make)(const MethodParams& params, MethodInput&& input);

    /// Add the parameters that determine its textures to a texture file's metadata.
    void (*describe)(const MethodParams& params, openvdb::MetaMap& metadata);

    /// The memory that a run takes at its peak [bytes]. Fitted to measured runs: within a quarter of them for domains
    /// of full leaves. @param first frame  @param given refinement  @param withHits whether hits are
    /// kept
    double (*bytes)(const MethodParams& params, const FrameDomain& first, const Refinement& given, bool withHits);
    /// The same by the voxels of whole leaves alone, and the processor time of a frame as a multiple of auflic's; of
    /// methods that the inspection of a sequence estimates beside the default.
    struct Estimate {
        double (*bytes)(double velocity, double texture);
        double time;
    };
    const Estimate* estimate = nullptr;
};

} // namespace vdblic
