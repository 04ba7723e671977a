#include "view/connection.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

namespace vdblic::view {
namespace {

using std::chrono_literals::operator""ms;

constexpr auto kLong = 60000ms; // for what is there or comes

/// The two ends of a connection.
struct Pair {
    int server, client;

    Pair()
    {
        std::array<int, 2> ends{};
        if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) throw std::runtime_error("no socket");
        server = ends[0];
        client = ends[1];
    }
    ~Pair()
    {
        ::close(server);
        ::close(client);
    }
    Pair(const Pair&) = delete;
    Pair& operator=(const Pair&) = delete;

    void send(std::string_view text) const { EXPECT_EQ(::send(client, text.data(), text.size(), 0), text.size()); }
    void end() const { ::shutdown(client, SHUT_WR); }
    /// Whether the server's end has been shut down.
    [[nodiscard]] bool isShut() const
    {
        char byte;
        return ::recv(client, &byte, 1, MSG_DONTWAIT) == 0;
    }
};

/// What a reader hands on without waiting.
std::string buffered(RequestReader& reader)
{
    std::string text;
    while (reader.hasMore()) {
        std::array<char, 7> bytes;
        text.append(bytes.data(), reader.read(bytes.data(), bytes.size()));
    }
    return text;
}

struct Reading : testing::Test {
    Pair pair;
    Connections connections{8};
    RequestReader reader{pair.server, connections};
};

TEST_F(Reading, AHeadMayComeInPieces)
{
    const std::string head = "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n";
    std::thread client([&] {
        for (const char c : head)
            pair.send({&c, 1});
    });
    EXPECT_TRUE(reader.readHead(kLong));
    client.join();
    EXPECT_EQ(buffered(reader), head);
}

TEST_F(Reading, RequestsFollowEachOtherOnAConnection)
{
    const std::string first = "GET /a HTTP/1.1\r\n\r\n", second = "GET /b HTTP/1.1\r\n\r\n";
    pair.send(first + second);
    ASSERT_TRUE(reader.readHead(kLong));
    std::string head(first.size(), ' ');
    EXPECT_EQ(reader.read(head.data(), head.size()), head.size());
    EXPECT_EQ(head, first);
    ASSERT_TRUE(reader.readHead(kLong));
    EXPECT_EQ(buffered(reader), second);
}

TEST_F(Reading, RangesAreLeftOut)
{
    pair.send("GET / HTTP/1.1\r\nRange: bytes=0-1,3-4\r\nHost: a\r\nRANGE:x\r\nX-Range: y\r\n\r\nRange: body");
    ASSERT_TRUE(reader.readHead(kLong));
    EXPECT_EQ(buffered(reader), "GET / HTTP/1.1\r\nHost: a\r\nX-Range: y\r\n\r\nRange: body");
}

TEST_F(Reading, AHeadThatEndsEarlyIsNone)
{
    pair.send("GET / HTTP/1.1\r\nHost");
    pair.end();
    EXPECT_FALSE(reader.readHead(kLong));
}

TEST_F(Reading, AClientThatSendsNothingIsNotWaitedForLonger)
{
    EXPECT_FALSE(reader.readHead(5ms));
}

TEST_F(Reading, AHeadHasALimit)
{
    const auto head = [](std::size_t size) {
        return "GET / HTTP/1.1\r\nX: " + std::string(size - 23, 'x') + "\r\n\r\n";
    };
    ASSERT_EQ(head(100).size(), 100);
    pair.send(head(RequestReader::kMostHead));
    ASSERT_TRUE(reader.readHead(kLong));
    EXPECT_EQ(buffered(reader).size(), RequestReader::kMostHead);
    pair.send(head(RequestReader::kMostHead + 1));
    EXPECT_FALSE(reader.readHead(kLong));
}

TEST_F(Reading, ABodyHasALimit)
{
    std::thread client([&] {
        pair.send("POST / HTTP/1.1\r\n\r\n");
        const std::string part(1 << 16, 'x');
        for (std::size_t sent = 0; sent <= RequestReader::kMostBody; sent += part.size())
            (void)::send(pair.client, part.data(), part.size(), MSG_NOSIGNAL);
    });
    ASSERT_TRUE(reader.readHead(kLong));
    std::size_t size = 0;
    std::array<char, 10000> bytes;
    while (const std::size_t count = reader.read(bytes.data(), bytes.size()))
        size += count;
    ::shutdown(pair.server, SHUT_RDWR);
    client.join();
    EXPECT_GE(size, RequestReader::kMostBody);
    EXPECT_LE(size, RequestReader::kMostBody + RequestReader::kMostHead); // what came with the head
}

TEST(OpenConnections, TheOneThatHasWaitedLongestIsClosed)
{
    const Pair a, b, c;
    Connections connections(2);
    for (const Pair* pair : {&a, &b}) {
        connections.begins();
        connections.waits(pair->server);
    }
    connections.leaves(a.server); // it sent something
    connections.waits(a.server);
    EXPECT_FALSE(a.isShut() || b.isShut());
    connections.begins();
    EXPECT_TRUE(b.isShut());
    EXPECT_FALSE(a.isShut());
    // One that is shut counts no more, before and after its end.
    connections.waits(c.server);
    connections.ends(b.server);
    EXPECT_FALSE(a.isShut() || c.isShut());
    connections.closeAll();
    EXPECT_TRUE(a.isShut() && c.isShut());
}

TEST(OpenConnections, NoRequestThatWasSentIsLost)
{
    const Pair a, b;
    Connections connections(1);
    for (const Pair* pair : {&a, &b}) {
        connections.begins();
        pair->send("G");
        connections.waits(pair->server); // its thread has not run yet
    }
    EXPECT_FALSE(a.isShut() || b.isShut());
    char byte = 0;
    ASSERT_EQ(::recv(a.server, &byte, 1, 0), 1);
    connections.leaves(a.server);
    connections.waits(a.server);
    EXPECT_TRUE(a.isShut());
    EXPECT_FALSE(b.isShut());
}

TEST(OpenConnections, NoneThatIsServedIsClosed)
{
    const Pair a, b;
    Connections connections(1);
    connections.begins();
    connections.begins();
    EXPECT_FALSE(a.isShut() || b.isShut());
    connections.waits(a.server); // the first that can be
    EXPECT_TRUE(a.isShut());
    EXPECT_FALSE(b.isShut());
}

} // namespace
} // namespace vdblic::view
