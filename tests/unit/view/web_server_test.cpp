#include "view/web_server.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <array>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <future>
#include <iterator>
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

    /// A connection over which requests were sent, by default one for a page.
    [[nodiscard]] int ask(const std::string& request = "GET /token/page HTTP/1.1\r\nHost: localhost\r\n"
                                                       "Connection: close\r\n\r\n") const
    {
        const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(std::uint16_t(mServer.port()));
        ::inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
        EXPECT_EQ(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
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

/// How many files, pipes and connections this process has.
std::ptrdiff_t descriptors()
{
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
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
    std::promise<std::ptrdiff_t> withConnection;
    const Serving serving(
        [&](const WebRequest&) {
            withConnection.set_value(descriptors());
            return WebAnswer{200, "text/plain", std::string(size, 'x')};
        },
        100ms);
    const int socket = serving.ask();
    const std::ptrdiff_t before = withConnection.get_future().get();
    while (descriptors() >= before) // until the server has closed its end
        std::this_thread::sleep_for(1ms);
    EXPECT_LT(answer(socket).size(), size);
}

WebAnswer echo(const WebRequest& request)
{
    return {200, "text/plain", fmt::format("<{} {}>", request.path, request.body)};
}

TEST(Requests, FollowEachOtherOnAConnection)
{
    const Serving serving(echo, 10000ms);
    const std::string head = "POST /token/a HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n";
    const std::string text =
        answer(serving.ask(head + "Content-Length: 2\r\n\r\n{}" + head +
                           "Transfer-Encoding: chunked\r\n\r\n1\r\n[\r\n1\r\n]\r\n0\r\n\r\n"
                           "GET /token/b?c HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"));
    const std::size_t first = text.find("<a {}>"), second = text.find("<a []>"), third = text.find("<b >");
    EXPECT_TRUE(first < second && second < third && third != std::string::npos) << text;
}

TEST(Requests, HaveALimit)
{
    const Serving serving(echo, 10000ms);
    const auto withHead = [&](std::size_t size) {
        const std::string head = "GET /token/a HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nX: ";
        return answer(serving.ask(head + std::string(size - head.size() - 4, 'x') + "\r\n\r\n"));
    };
    EXPECT_TRUE(withHead(32 << 10).ends_with("<a >"));
    EXPECT_FALSE(withHead(33 << 10).ends_with("<a >"));
    const std::string head = "POST /token/a HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                             "Connection: close\r\n";
    const auto withBody = [&](std::size_t size) {
        return answer(serving.ask(head + fmt::format("Content-Length: {}\r\n\r\n", size) + std::string(size, ' ')));
    };
    EXPECT_TRUE(withBody(1 << 20).ends_with(" >"));
    EXPECT_TRUE(withBody((1 << 20) + 1).starts_with("HTTP/1.1 413 "));
}

TEST(Requests, ThatAreRefusedEndTheConnection)
{
    const Serving serving(echo, 10000ms);
    const std::string text = answer(serving.ask("GET /other/a HTTP/1.1\r\nHost: localhost\r\n\r\n"
                                                "GET /token/b HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    EXPECT_TRUE(text.starts_with("HTTP/1.1 403 ")) << text;
    EXPECT_EQ(text.find("<b"), std::string::npos);
}

} // namespace
} // namespace vdblic::view
