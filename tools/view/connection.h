#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <mutex>
#include <set>
#include <string>

namespace vdblic::view {

/// The open connections. Of too many the one that has waited longest for its client is closed, if all that came from it
/// was read.
class Connections {
  public:
    explicit Connections(std::size_t most) : mMost(most) {}

    /// A connection was accepted.
    void begins();
    /// @param socket whose peer has to send something
    void waits(int socket);
    /// @param socket whose peer has sent something
    void leaves(int socket);
    /// @param socket that is about to be closed
    void ends(int socket);
    /// Shut down all that wait, from now on.
    void closeAll();

  private:
    void closeTooMany();

    std::size_t mMost;
    std::mutex mMutex;
    std::size_t mOpen = 0;
    std::list<int> mWaiting; // the one that has waited longest first
    std::set<int> mShut;     // that have not ended yet
};

/// Reads requests from a socket, up to a size and a time for each.
class RequestReader {
  public:
    static constexpr std::size_t kMostHead = 32 << 10, kMostBody = 1 << 20; ///< bytes

    RequestReader(int socket, Connections& connections) : mSocket(socket), mConnections(connections) {}

    /// Read the head of a request. Headers that ask for parts of an answer (Range) are left out.
    /// @param idle how long to wait for its first byte
    /// @return false at the end of the connection, or if the head is too long or too slow
    [[nodiscard]] bool readHead(std::chrono::milliseconds idle);
    /// Bytes of the head, then of the body. @return their number; 0 at the end or beyond the limits
    [[nodiscard]] std::size_t read(char* bytes, std::size_t count);
    /// Whether there are bytes that were sent without waiting for the answer.
    [[nodiscard]] bool hasMore() const { return mNext < mBuffer.size(); }

  private:
    [[nodiscard]] std::size_t receive(char* bytes, std::size_t count);

    int mSocket;
    Connections& mConnections;
    std::string mBuffer;   // what was received and not read
    std::size_t mNext = 0; // in the buffer
    std::size_t mLeft = 0; // bytes of body that may come
    std::chrono::steady_clock::time_point mDeadline{};
};

} // namespace vdblic::view
