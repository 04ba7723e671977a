#pragma once

#include "vdblic/camera/camera.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace vdblic {

/// Key frames of one property of the camera, by rising frame number.
///
/// Between keys a cubic Hermite curve (Catmull-Rom with the keys' own spacing), so that motion is smooth. Between two
/// equal keys the property rests: the slope is 0 at both. Constant before the first key and after the last.
template<typename Value>
class CameraTrack {
  public:
    void add(std::int64_t frame, const Value& value) { mKeys.emplace_back(frame, value); }
    [[nodiscard]] bool empty() const { return mKeys.empty(); }
    [[nodiscard]] Value at(double frame) const;

  private:
    [[nodiscard]] Value slope(std::size_t key) const; // per frame

    std::vector<std::pair<std::int64_t, Value>> mKeys;
};

/// The camera's key frames; a property without keys comes from CameraParams.
struct CameraKeys {
    CameraTrack<glm::dvec3> eye, target, up;
    CameraTrack<double> fieldOfView, viewHeight;

    [[nodiscard]] bool empty() const;
    [[nodiscard]] CameraParams applied(CameraParams params, double frame) const;
};

/// Read key frames: {"keys": [{"frame": 1, "eye": [x, y, z], "target": ..., "up": ..., "fov": 35, "height": 2}, ...]}.
/// A key that leaves out a property does not affect that property's curve.
/// @throws InputError naming the file, the key and the remedy
[[nodiscard]] CameraKeys readCameraKeys(const std::filesystem::path& path);

/// How the camera moves during a sequence.
struct CameraMotion {
    double orbit = 0;                          ///< turns around the target, about up; counter-clockwise seen from above
    std::optional<std::int64_t> orbitFrames{}; ///< number of frames for the turns; unset: the sequence's
    CameraKeys keys{};

    /// @throws ParameterError
    void validate() const;
};
[[nodiscard]] Parameters parametersOf(CameraMotion& params);

/// The frames of a sequence: the number of the first one, and how many numbers there are until it repeats.
struct FrameSpan {
    std::int64_t first = 1, length = 1;
};

/// The camera of every frame. Automatic choices are made once, so that nothing jumps, and for an orbit such that all is
/// seen from everywhere. Immutable.
class CameraPath {
  public:
    /// @param box     around everything visible in the whole sequence
    /// @param subject points that fill the picture; empty: the box's corners
    /// @throws ParameterError
    CameraPath(const CameraParams& params, const CameraMotion& motion, const Corners& box, const glm::ivec2& size,
               const FrameSpan& span, std::vector<glm::dvec3> subject = {});

    /// @param frame number; between two frames a number between theirs
    /// @throws ParameterError naming the frame if key frames leave the camera nowhere to look
    [[nodiscard]] Camera at(double frame) const;
    /// Of the sequence's first frame. @throws ParameterError
    [[nodiscard]] Camera first() const { return at(double(mSpan.first)); }

  private:
    CameraParams mParams;
    CameraKeys mKeys;
    Corners mBox;
    glm::ivec2 mSize;
    FrameSpan mSpan;
    double mOrbit;
};

} // namespace vdblic
