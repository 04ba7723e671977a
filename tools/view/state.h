#pragma once

#include "vdblic/io/sequence.h"
#include "vdblic/render/render_params.h"
#include "vdblic/render/render_plan.h"

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
    Given fixed; ///< parameters that name files, by key: no state changes them
    nlohmann::json state;
    std::string solid; ///< the file that the state may name as `solid`; or empty
    SequenceTraits traits;
};

/// @param given parameters of pictures, by key. @throws ParameterError; InputError naming the file of key frames
[[nodiscard]] Start startOf(const Given& given, const SequenceParams& input);

/// The arguments of vdblic_render for a state; its key frames are left out.
/// @throws ParameterError on a value that no state holds, such as a file that the command line does not name
[[nodiscard]] std::vector<std::string> argumentsOf(const Start& start, const nlohmann::json& state);

/// The plan by which vdblic_render would make the pictures of a state. @throws ParameterError, InputError
[[nodiscard]] PicturePlan planOf(const Start& start, const nlohmann::json& state);

/// The command for a shell that renders the state. @param last further arguments
[[nodiscard]] std::string commandOf(const Start& start, const nlohmann::json& state,
                                    const std::vector<std::string>& last);

/// Words as a command for a shell.
[[nodiscard]] std::string shellCommand(const std::vector<std::string>& words);

} // namespace vdblic::view
