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

/// Input of textures beside the flow and the method's parameters.
struct MethodInput {
    NoiseField noise;
    std::uint32_t seed = 1;  ///< of the noise
    Refinement refinement{}; ///< as given
};

/// A method, as seen by the rest of the library. Each is described in its own folder, under its paper, and listed in
/// `registry.cpp`, the only place that names all of them (docs/architecture.md).
struct TextureMethod {
    std::string_view name; ///< as the parameter `method`, texture files and reports spell it
    std::string_view text; ///< description for the help

    bool isSteady = false; ///< whether a texture depends on its frame alone
    bool isSparse = false; ///< whether textures have voxels of their own, not refined ones of the flow
    bool blends = false;   ///< whether a share of new noise is blended into each frame (BackwardParams::alpha)
    const ScatterMethod* scatter = nullptr; ///< how values are scattered along pathlines; null: voxels collect no hits

    int finish = 0; ///< default of FinishParams::taps
    /// Default number of frames during which the first one stands still.
    int (*preroll)(const MethodParams& params);
    /// Default number of frames on disk to compute before the selected ones.
    int (*leadIn)(const MethodParams& params);

    std::unique_ptr<FlowTexture> (*make)(const MethodParams& params, MethodInput&& input);

    /// Add the parameters that determine the textures to a texture file's metadata.
    void (*describe)(const MethodParams& params, openvdb::MetaMap& metadata);

    /// Peak memory of a run [bytes], fitted to measured runs: within a quarter of them for domains of full leaves.
    /// @param first frame  @param given refinement  @param withHits whether hits are kept
    double (*bytes)(const MethodParams& params, const FrameDomain& first, const Refinement& given, bool withHits);
    /// The same by the voxels of whole leaves alone, and the processor time per frame relative to auflic's. For methods
    /// that the inspection of a sequence lists beside the default.
    struct Estimate {
        double (*bytes)(double velocity, double texture);
        double time;
    };
    const Estimate* estimate = nullptr;
};

} // namespace vdblic
