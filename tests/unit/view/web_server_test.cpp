#include "view/web_server.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <array>
#include <chrono>
#include <netinet/in.h>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

namespace vdblic::view {
namespace {

using std::chrono_literals::operator""ms;

/// Serves while it exists.
class Serving {
  public:
    Serving(WebServer::Handler handler, std::chrono::milliseconds writing)
        : mServer("127.0.0.1", 0, "token", std::move(handler), writing), mThread([this] { mServer.serve(); })
    {
    }
    ~Serving()
    {
        mServer.stop();
        mThread.join();
    }
    Serving(const Serving&) = delete;
    Serving& operator=(const Serving&) = delete;

    /// A connection that has asked for a page.
    [[nodiscard]] int ask() const
    {
        const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(std::uint16_t(mServer.port()));
        ::inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
        EXPECT_EQ(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
        const std::string request = "GET /token/page HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
        EXPECT_EQ(::send(socket, request.data(), request.size(), 0), ssize_t(request.size()));
        return socket;
    }

  private:
    WebServer mServer;
    std::thread mThread;
};

/// All that comes from a connection, which is then closed.
std::string answer(int socket)
{
    std::string text;
    std::array<char, 65536> part;
    ssize_t count = 0;
    while ((count = ::recv(socket, part.data(), part.size(), 0)) > 0)
        text.append(part.data(), std::size_t(count));
    ::close(socket);
    return text;
}

TEST(Answers, MayTakeLongerToMakeThanToSend)
{
    const Serving serving(
        [](const WebRequest& request) {
            std::this_thread::sleep_for(300ms);
            return WebAnswer{200, "text/plain", request.path};
        },
        100ms);
    const std::string text = answer(serving.ask());
    EXPECT_TRUE(text.starts_with("HTTP/1.1 200 ")) << text;
    EXPECT_TRUE(text.ends_with("\r\n\r\npage")) << text;
}

TEST(Answers, AreNotSentForeverToAClientThatDoesNotRead)
{
    const std::size_t size = std::size_t(64) << 20; // more than the system takes for it
    const Serving serving(
        [&](const WebRequest&) {
            return WebAnswer{200, "text/plain", std::string(size, 'x')};
        },
        100ms);
    const int socket = serving.ask();
    std::this_thread::sleep_for(500ms);
    EXPECT_LT(answer(socket).size(), size);
}

} // namespace
} // namespace vdblic::view
