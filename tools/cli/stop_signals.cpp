#include "cli/stop_signals.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <istream>
#include <memory>
#include <poll.h>
#include <streambuf>
#include <unistd.h>

namespace vdblic::cli {
namespace {

std::atomic<int> gSignal{0};
static_assert(std::atomic<int>::is_always_lock_free);
std::array<int, 2> gWake = {-1, -1}; // a pipe that the signal makes readable

extern "C" void onStopSignal(int signal)
{
    const int before = errno;
    gSignal = signal;
    (void)!::write(gWake[1], "", 1);
    errno = before;
}

class StoppableBuffer : public std::streambuf {
  protected:
    int_type underflow() override
    {
        std::array<pollfd, 2> ready = {{{STDIN_FILENO, POLLIN, 0}, {gWake[0], POLLIN, 0}}};
        ssize_t count = 0;
        do {
            if (stopSignal() != 0) return traits_type::eof();
            if (::poll(ready.data(), ready.size(), -1) < 0 || ready[0].revents == 0) continue;
            count = ::read(STDIN_FILENO, mBytes.data(), mBytes.size());
            if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) return traits_type::eof();
        } while (count <= 0);
        setg(mBytes.data(), mBytes.data(), mBytes.data() + count);
        return traits_type::to_int_type(*gptr());
    }

  private:
    std::array<char, 4096> mBytes;
};

class StoppableInput : public std::istream {
  public:
    StoppableInput() : std::istream(nullptr) { rdbuf(&mBuffer); }

  private:
    StoppableBuffer mBuffer;
};

} // namespace

void catchStopSignals()
{
    if (::pipe2(gWake.data(), O_CLOEXEC | O_NONBLOCK) != 0) gWake = {-1, -1};
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
        struct sigaction before {};
        ::sigaction(signal, nullptr, &before);
        if (before.sa_handler == SIG_IGN) continue;
        struct sigaction action {};
        action.sa_handler = onStopSignal;
        action.sa_flags = int(SA_RESETHAND); // without SA_RESTART: a wait for a pipe ends, too
        ::sigaction(signal, &action, nullptr);
    }
}

int stopSignal()
{
    return gSignal;
}

void dieBy(int signal)
{
    std::signal(signal, SIG_DFL);
    (void)std::raise(signal);
    std::_Exit(128 + signal); // the signal is blocked
}

std::unique_ptr<std::istream> stoppableInput()
{
    return std::make_unique<StoppableInput>();
}

} // namespace vdblic::cli
