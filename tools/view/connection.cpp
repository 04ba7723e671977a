#include "view/connection.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <poll.h>
#include <string_view>
#include <sys/socket.h>

namespace vdblic::view {
namespace {

using Clock = std::chrono::steady_clock;

/// Time for a whole request.
constexpr std::chrono::seconds kMostTime{10};

/// Wait until a socket can be read. @return false if it cannot in time
bool waitUntil(int socket, Clock::time_point deadline)
{
    for (;;) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
        if (left <= 0) return false;
        pollfd state{socket, POLLIN, 0};
        const int ready = ::poll(&state, 1, int(left));
        if (ready > 0) return true;
        if (ready < 0 && errno != EINTR) return false;
    }
}

bool canBeRead(int socket)
{
    pollfd state{socket, POLLIN, 0};
    return ::poll(&state, 1, 0) > 0;
}

/// A head without its Range headers: their pattern would be matched at a depth that follows their length.
std::string withoutRanges(std::string_view head)
{
    std::string result;
    while (!head.empty()) {
        const std::string_view line = head.substr(0, head.find('\n') + 1);
        constexpr std::string_view kRange = "range:";
        const bool isRange =
            line.size() >= kRange.size() && std::equal(kRange.begin(), kRange.end(), line.begin(), [](char a, char b) {
                return a == std::tolower(static_cast<unsigned char>(b));
            });
        if (!isRange) result += line;
        head.remove_prefix(line.size());
    }
    return result;
}

} // namespace

void Connections::begins()
{
    const std::lock_guard lock(mMutex);
    ++mOpen;
    closeTooMany();
}

void Connections::waits(int socket)
{
    const std::lock_guard lock(mMutex);
    mWaiting.push_back(socket);
    closeTooMany();
}

void Connections::leaves(int socket)
{
    const std::lock_guard lock(mMutex);
    mWaiting.remove(socket);
}

void Connections::ends(int socket)
{
    const std::lock_guard lock(mMutex);
    mShut.erase(socket);
    --mOpen;
}

void Connections::closeAll()
{
    const std::lock_guard lock(mMutex);
    mMost = 0;
    closeTooMany();
}

void Connections::closeTooMany()
{
    // What a client has sent is read before its connection is closed, or its request would be lost.
    for (auto waiting = mWaiting.begin(); mOpen - mShut.size() > mMost && waiting != mWaiting.end();) {
        if (mMost > 0 && canBeRead(*waiting)) {
            ++waiting;
            continue;
        }
        ::shutdown(*waiting, SHUT_RDWR);
        mShut.insert(*waiting);
        waiting = mWaiting.erase(waiting);
    }
}

bool RequestReader::readHead(std::chrono::milliseconds idle)
{
    mBuffer.erase(0, mNext);
    mNext = 0;
    mLeft = kMostBody;
    mDeadline = Clock::now() + idle;
    std::array<char, 4096> bytes;
    for (std::size_t end = mBuffer.find("\r\n\r\n"); end == std::string::npos; end = mBuffer.find("\r\n\r\n")) {
        if (mBuffer.size() > kMostHead) return false;
        const std::size_t count = receive(bytes.data(), bytes.size());
        if (count == 0) return false;
        if (mBuffer.empty()) mDeadline = Clock::now() + kMostTime;
        mBuffer.append(bytes.data(), count);
    }
    const std::size_t end = mBuffer.find("\r\n\r\n") + 4;
    if (end > kMostHead) return false;
    mBuffer = withoutRanges(std::string_view(mBuffer).substr(0, end)) + mBuffer.substr(end);
    return true;
}

std::size_t RequestReader::read(char* bytes, std::size_t count)
{
    if (hasMore()) {
        const std::size_t copied = mBuffer.copy(bytes, count, mNext);
        mNext += copied;
        return copied;
    }
    const std::size_t received = receive(bytes, std::min(count, mLeft));
    mLeft -= received;
    return received;
}

std::size_t RequestReader::receive(char* bytes, std::size_t count)
{
    if (count == 0) return 0;
    mConnections.waits(mSocket);
    const bool ready = waitUntil(mSocket, mDeadline);
    mConnections.leaves(mSocket);
    if (!ready) return 0;
    const ssize_t received = ::recv(mSocket, bytes, count, 0);
    return received > 0 ? std::size_t(received) : 0;
}

} // namespace vdblic::view
