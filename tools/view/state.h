#pragma once

#include "vdblic/io/sequence.h"
#include "vdblic/render/render_params.h"

#include <nlohmann/json.hpp>

#include <map>
#include <string>
#include <vector>

namespace vdblic::view {

/// What the command line determines: the sequence, options that name files, and the state that pages begin with.
///
/// A state is an object that holds options of vdblic_render by their names without dashes: numbers, texts, lists of
/// numbers, and lists of those for options that may be repeated. `keys` holds key frames of the camera.
struct Start {
    SequenceParams input;
    std::map<std::string, Words> fixed; ///< parameters that name files, by key: no state changes them
    nlohmann::json state;
    std::string solid;     ///< the file that the state may name as `solid`; or empty
    bool isSparse = false; ///< of the sequence's textures: they have another look where a state names none
};

/// @param given parameters of a picture, by key. @throws ParameterError; InputError naming the file of key frames
[[nodiscard]] Start startOf(const std::map<std::string, Words>& given, const SequenceParams& input);

/// The arguments of vdblic_render for a state; its key frames are left out.
/// @throws ParameterError on what a state cannot hold; no state names a file that the command line does not
[[nodiscard]] std::vector<std::string> argumentsOf(const Start& start, const nlohmann::json& state);

/// The parameters that vdblic_render would have for a state. @throws ParameterError, InputError
[[nodiscard]] RenderParams paramsOf(const Start& start, const nlohmann::json& state);

/// The command for a shell that renders the state. @param last further arguments
[[nodiscard]] std::string commandOf(const Start& start, const nlohmann::json& state,
                                    const std::vector<std::string>& last);

/// Words as a command for a shell.
[[nodiscard]] std::string shellCommand(const std::vector<std::string>& words);

} // namespace vdblic::view
