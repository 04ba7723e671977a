#pragma once

#include "vdblic/core/parameters.h"

#include <glm/vec3.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// A light so far away that its rays are parallel.
struct DirectionalLight {
    glm::dvec3 direction; ///< towards the light, world space; any length but 0
    double intensity = 1;
};

/// The lighting model of samples.
enum class ShadingModel {
    kSurface, ///< as a surface with the texture's gradient as its normal: Phong's reflection
    kLine,    ///< as a thin line in the direction of least change of the texture (Zöckler, Stalling & Hege 1996)
    kNone,    ///< not at all: colours are the transfer function's
};

template<>
inline constexpr auto kNames<ShadingModel> = std::to_array<std::string_view>({"phong", "lines", "none"});

/// Ambient, diffuse and specular reflection of white lights: one at the eye, and directional ones.
///
/// Samples have no outer side: the side that is seen is lit. Highlights have Schlick's rational approximation of a
/// power (Graphics Gems IV, 1994). A line has a whole circle of normals: 1 − (l·t)² stands for Phong's n·l, squared
/// after Banks (1994) so that not everything is bright.
struct Shading {
    ShadingModel model = ShadingModel::kSurface;
    float ambient = 0.45f;
    float diffuse = 0.9f;
    float specular = 0.2f;
    float shininess = 12;
    float headLight = 1; ///< intensity of the light at the eye
    std::vector<DirectionalLight> lights{};
    /// Gradients of the stretched texture [1/voxel] far below this are no surface and are not lit.
    float leastGradient = 0.08f;

    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(Shading& params);

} // namespace vdblic
