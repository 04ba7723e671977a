#include "vdblic/methods/registry.h"

#include "vdblic/core/errors.h"
#include "vdblic/methods/auflic/auflic.h"
#include "vdblic/methods/ibfv/ibfv.h"
#include "vdblic/methods/lea/lea.h"
#include "vdblic/methods/lic/lic.h"
#include "vdblic/methods/streaks/streaks.h"
#include "vdblic/methods/ufac/ufac.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>
#include <utility>
#include <vector>

namespace vdblic {

std::span<const TextureMethod* const> textureMethods()
{
    static constexpr const TextureMethod* kMethods[] = {
        &kAuflic, &kAuflic2004, &kUflic, &kLic, &kStreaks, &kIbfv, &kLea, &kUfac,
    };
    return kMethods;
}

const TextureMethod& textureMethod(std::string_view name)
{
    std::vector<std::string_view> names;
    for (const TextureMethod* const method : textureMethods()) {
        if (method->name == name) return *method;
        names.push_back(method->name);
    }
    throw ParameterError(fmt::format("'{}' is none of {}", name, fmt::join(names, ", ")));
}

std::unique_ptr<FlowTexture> makeFlowTexture(const MethodParams& params, MethodInput input)
{
    params.texture.validate();
    params.streaks.validate();
    params.backward.validate();
    return params.texture.method->make(params, std::move(input));
}

} // namespace vdblic
