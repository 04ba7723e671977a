#include "vdblic/lic/lic_kernel.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

namespace vdblic {

LicKernel parseLicKernel(std::string_view text)
{
    if (text == "hann") return LicKernel::kHann;
    if (text == "box") return LicKernel::kBox;
    throw ParameterError(fmt::format("kernel '{}' is neither hann nor box", text));
}

std::string_view toString(LicKernel kernel)
{
    return kernel == LicKernel::kHann ? "hann" : "box";
}

} // namespace vdblic
