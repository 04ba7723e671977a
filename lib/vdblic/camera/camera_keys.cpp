#include "vdblic/camera/camera_keys.h"

#include "vdblic/camera/camera_path.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/json_file.h"

#include <fmt/format.h>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace vdblic {
namespace {

using Json = nlohmann::json;

constexpr double kMostFrames = 1e12;

double parseNumber(const Json& value, const std::string& what)
{
    if (value.is_number() && std::isfinite(value.get<double>())) return value.get<double>();
    throw InputError(fmt::format("{} is {}, not a number", what, value.dump()));
}

glm::dvec3 parseVector(const Json& value, const std::string& what)
{
    if (!value.is_array() || value.size() != 3) {
        throw InputError(fmt::format("{} is {}, not three numbers [x, y, z]", what, value.dump()));
    }
    return {parseNumber(value[0], what), parseNumber(value[1], what), parseNumber(value[2], what)};
}

std::int64_t parseFrame(const Json& key, const std::string& what)
{
    if (!key.is_object() || !key.contains("frame") || !key["frame"].is_number_integer()) {
        throw InputError(fmt::format("{} has no whole number \"frame\"", what));
    }
    const auto frame = key["frame"].get<double>(); // an integer type might hold another number
    if (std::abs(frame) > kMostFrames) throw InputError(fmt::format("{}: frame {:.0f} is no usable one", what, frame));
    return std::int64_t(frame);
}

} // namespace

CameraKeys parseCameraKeys(const Json& json)
{
    if (!json.is_object() || json.size() != 1 || !json.contains("keys") || !json["keys"].is_array() ||
        json["keys"].empty()) {
        throw InputError(R"(it must be {"keys": [...]} with at least one key)");
    }
    CameraKeys keys;
    std::int64_t last = std::numeric_limits<std::int64_t>::min();
    for (std::size_t i = 0; i < json["keys"].size(); ++i) {
        const Json& key = json["keys"][i];
        const std::int64_t frame = parseFrame(key, fmt::format("key {}", i + 1));
        const std::string keyName = fmt::format("the key of frame {}", frame);
        if (frame <= last)
            throw InputError(fmt::format("{} comes after that of frame {}; sort the keys", keyName, last));
        last = frame;
        for (const auto& [name, value] : key.items()) {
            const std::string what = fmt::format("{}: \"{}\"", keyName, name);
            if (name == "eye") {
                keys.eye.add(frame, parseVector(value, what));
            } else if (name == "target") {
                keys.target.add(frame, parseVector(value, what));
            } else if (name == "up") {
                keys.up.add(frame, parseVector(value, what));
            } else if (name == "fov") {
                keys.fieldOfView.add(frame, parseNumber(value, what));
            } else if (name == "height") {
                keys.viewHeight.add(frame, parseNumber(value, what));
            } else if (name != "frame") {
                throw InputError(fmt::format("{} is unknown; a key has frame, eye, target, up, fov, height", what));
            }
        }
    }
    return keys;
}

CameraKeys readCameraKeys(const std::filesystem::path& path)
{
    const Json file = readJson(path);
    try {
        return parseCameraKeys(file);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", path.string(), error.what()));
    }
}

} // namespace vdblic
