#include "cli/failure.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/paging.h"

#include <fmt/format.h>

#include <exception>
#include <new>
#include <string_view>
#include <system_error>

namespace vdblic::cli {
namespace {

ExitStatus tellBug(Console& console, std::string_view what)
{
    console.error(fmt::format("internal error, please report it: {}", what));
    return ExitStatus::kBug;
}

ExitStatus tellLackOfMemory(Console& console)
{
    if (const char* const scratch = paging::problem()) {
        console.error(scratch);
        return ExitStatus::kCannotWrite;
    }
    console.error(fmt::format("this takes more than the {} of memory that may be used: cut the domain, use fewer "
                              "threads, or raise --max-memory",
                              memoryText(double(memoryLimit()))));
    return ExitStatus::kBadInput;
}

} // namespace

ExitStatus tellFailure(Console& console)
{
    try {
        throw;
    } catch (const Stopped&) {
        throw;
    } catch (const ClosedPipe&) {
        throw;
    } catch (const ParameterError& error) {
        console.error(error.what());
        return ExitStatus::kUsage;
    } catch (const InputError& error) {
        console.error(error.what());
        return ExitStatus::kBadInput;
    } catch (const OutputError& error) {
        console.error(error.what());
        return ExitStatus::kCannotWrite;
    } catch (const std::bad_alloc&) {
        return tellLackOfMemory(console);
    } catch (const std::system_error& error) {
        if (error.code() != std::errc::resource_unavailable_try_again) return tellBug(console, error.what());
        console.error("no further thread can be started: use fewer --threads, raise --max-memory, which includes 8 MiB "
                      "a thread, or allow the user more processes (ulimit -u)");
        return ExitStatus::kBadInput;
    } catch (const std::exception& error) {
        return tellBug(console, error.what());
    } catch (...) {
        return tellBug(console, "an exception that is no std::exception");
    }
}

} // namespace vdblic::cli
