#include "vdblic/core/hazard.h"

namespace vdblic {
namespace {

HazardHooks gHooks;

} // namespace

void setHazardHooks(const HazardHooks& hooks)
{
    gHooks = hooks;
}

Hazard::Hazard(const std::string& file, std::uint64_t size)
{
    if (gHooks.enter) gHooks.enter(file.c_str(), size);
}

Hazard::~Hazard()
{
    if (gHooks.leave) gHooks.leave();
}

} // namespace vdblic
