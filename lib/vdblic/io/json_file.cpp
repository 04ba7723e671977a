#include "vdblic/io/json_file.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/input_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <fstream>
#include <ios>
#include <string>
#include <system_error>

namespace vdblic {
namespace {

constexpr int kMostDepth = 16; // nlohmann::json prints, copies and frees nested values by recursion

/// "[json.exception.parse_error.101] parse error at line 3, column 5: syntax error while parsing value - unexpected
/// ..." → "line 3, column 5: unexpected ..."
std::string plainWords(const std::string& message)
{
    const std::size_t line = message.find("line "), colon = message.find(": ", line), dash = message.find(" - ", colon);
    if (dash == std::string::npos) return message;
    return fmt::format("{}: {}", message.substr(line, colon - line), message.substr(dash + 3));
}

template<typename Json>
std::string textOf(const Json& json, int indent)
{
    return json.dump(indent, ' ', false, Json::error_handler_t::replace) + '\n';
}

} // namespace

nlohmann::json readJson(const std::filesystem::path& path)
{
    checkRegular(path);
    errno = 0;
    std::ifstream stream(path);
    if (!stream) {
        throw InputError(fmt::format("{}: cannot be read: {}", path.string(), std::generic_category().message(errno)));
    }
    try {
        return nlohmann::json::parse(stream, [&](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
            if (depth > kMostDepth) throw InputError(fmt::format("{}: is nested too deeply", path.string()));
            return true;
        });
    } catch (const std::ios_base::failure&) { // of the disk: a stream's buffer throws it
        throw InputError(fmt::format("{}: cannot be read: {}", path.string(), std::generic_category().message(errno)));
    } catch (const nlohmann::json::exception& error) {
        throw InputError(fmt::format("{}: is no JSON: {}", path.string(), plainWords(error.what())));
    }
}

std::string jsonText(const nlohmann::json& json, int indent)
{
    return textOf(json, indent);
}

std::string jsonText(const nlohmann::ordered_json& json, int indent)
{
    return textOf(json, indent);
}

} // namespace vdblic
