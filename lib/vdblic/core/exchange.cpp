#include "vdblic/core/exchange.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/reporter.h"

#include <fmt/format.h>

#include <new>
#include <stdexcept>
#include <utility>

namespace vdblic {
namespace {

/// Kinds of errors reported between ranks, as the first character of a message.
enum Kind : char { kParameter = 'p', kInput = 'i', kOutput = 'o', kStopped = 's', kMemory = 'm', kOther = 'x' };

std::string described(const std::exception_ptr& why)
{
    try {
        std::rethrow_exception(why);
    } catch (const ParameterError& error) {
        return std::string(1, kParameter) + error.what();
    } catch (const InputError& error) {
        return std::string(1, kInput) + error.what();
    } catch (const OutputError& error) {
        return std::string(1, kOutput) + error.what();
    } catch (const Stopped&) {
        return std::string(1, kStopped);
    } catch (const std::bad_alloc&) {
        return std::string(1, kMemory);
    } catch (const std::exception& error) {
        return std::string(1, kOther) + error.what();
    } catch (...) { // a reporter's own: its reader has gone away
        return std::string(1, kStopped);
    }
}

[[noreturn]] void raise(const std::string& description)
{
    const std::string text = description.substr(1);
    switch (description[0]) {
    case kParameter:
        throw ParameterError(text);
    case kInput:
        throw InputError(text);
    case kOutput:
        throw OutputError(text);
    case kStopped:
        throw Stopped{};
    case kMemory:
        throw std::bad_alloc();
    default:
        throw std::runtime_error(text);
    }
}

} // namespace

/// Called before each collective call. The largest number of all ranks identifies the first rank that failed.
void Exchange::agree()
{
    if (isAlone()) return;
    double failed = 0;
    doMax({&failed, 1});
    if (failed == 0) return;
    mWasTold = true;
    raise(doBroadcast({}, size() - int(failed)));
}

void Exchange::fail(const std::exception_ptr& why) noexcept
{
    if (isAlone() || std::exchange(mWasTold, false)) return;
    try {
        double failed = size() - rank();
        doMax({&failed, 1});
        (void)doBroadcast(described(why), size() - int(failed));
    } catch (...) { // the first error is the one to report
    }
}

std::vector<Exchange::Bytes> Exchange::swap(std::vector<Bytes> messages)
{
    agree();
    for (int to = 0; to < size(); ++to)
        mSent += to == rank() ? 0 : messages[std::size_t(to)].size();
    return doSwap(std::move(messages));
}

std::vector<Exchange::Bytes> Exchange::gather(Bytes message)
{
    agree();
    return doGather(std::move(message));
}

Exchange::Bytes Exchange::broadcast(Bytes message)
{
    agree();
    return doBroadcast(std::move(message), 0);
}

void Exchange::sum(std::span<std::uint64_t> numbers)
{
    agree();
    doSum(numbers);
}

void Exchange::max(std::span<double> numbers)
{
    agree();
    doMax(numbers);
}

bool Exchange::any(bool here)
{
    double number = here ? 1 : 0;
    max({&number, 1});
    return number > 0;
}

} // namespace vdblic
