#include "vdblic/io/grid_reference.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <cstddef>
#include <system_error>

namespace vdblic {

GridReference parseGridReference(std::string_view text)
{
    const std::size_t colon = text.rfind(':');
    std::error_code ignored;
    if (!text.empty() && (colon == std::string_view::npos || std::filesystem::exists(text, ignored))) return {text, {}};
    if (text.empty() || colon == 0 || colon + 1 == text.size()) {
        throw ParameterError(fmt::format("'{}' is not FILE or FILE:GRID", text));
    }
    return {text.substr(0, colon), std::string(text.substr(colon + 1))};
}

} // namespace vdblic
