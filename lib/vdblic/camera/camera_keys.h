#pragma once

#include <nlohmann/json_fwd.hpp>

namespace vdblic {

struct CameraKeys;

/// Key frames in the form that readCameraKeys() describes. @throws InputError naming the key and the remedy
[[nodiscard]] CameraKeys parseCameraKeys(const nlohmann::json& json);

} // namespace vdblic
