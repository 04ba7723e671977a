#include "vdblic/core/hazard.h"

namespace vdblic {
namespace {

HazardHooks gHooks;
thread_local int tDepth = 0;

} // namespace

void setHazardHooks(const HazardHooks& hooks)
{
    gHooks = hooks;
}

Hazard::Hazard(const std::string& file, std::uint64_t size, const char* library)
{
    if (tDepth++ == 0 && gHooks.enter) gHooks.enter(file.c_str(), size, library);
}

Hazard::~Hazard()
{
    if (--tDepth == 0 && gHooks.leave) gHooks.leave();
}

} // namespace vdblic
