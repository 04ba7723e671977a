#include "vdblic/core/crash_guard.h"

#include <string>
#include <string_view>

// A library may abort while it is loaded: OpenVDB's log4cplus starts threads then. Code of this section runs before. A
// sanitizer is not ready then.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace {

void guardEarly(int argc, char** argv, char** /*environment*/)
{
    const std::string_view path = argc > 0 ? argv[0] : "vdblic";
    vdblic::guardAgainstCrashes(std::string(path.substr(path.rfind('/') + 1)));
}

[[gnu::section(".preinit_array"), gnu::used]] void (*const kGuardEarly)(int, char**, char**) = guardEarly;

} // namespace
#endif
