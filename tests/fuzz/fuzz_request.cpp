/// Any bytes as what a client of the viewer sends, in pieces: the first byte is their size. No head or body is beyond
/// the limits, no byte is made up, and no Range header is left.
#include "view/connection.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

namespace {

using vdblic::view::RequestReader;

void require(bool condition)
{
    if (!condition) std::abort();
}

/// Reads request after request, all in time, because the client has sent everything.
void readAll(int socket, std::string_view sent)
{
    vdblic::view::Connections connections(8);
    connections.begins();
    RequestReader reader(socket, connections);
    std::size_t count = 0;
    while (reader.readHead(std::chrono::seconds(5))) {
        require(reader.hasMore());
        std::string head;
        std::array<char, 5000> bytes;
        for (std::size_t size = 1; reader.hasMore() && size > 0; head.append(bytes.data(), size))
            size = reader.read(bytes.data(), bytes.size());
        const std::size_t end = head.starts_with("\r\n") ? 0 : head.find("\n\r\n"); // of the last line
        require(end + 3 <= RequestReader::kMostHead);
        for (std::size_t line = 0; line < end; line = head.find('\n', line) + 1) {
            std::string name = head.substr(line, 6);
            std::transform(name.begin(), name.end(), name.begin(),
                           [](unsigned char c) { return char(std::tolower(c)); });
            require(name != "range:");
        }
        count += head.size();
        // What follows is read as a body to its end, or left to the next head.
        if (sent.size() % 2 == 0) continue;
        std::size_t body = 0;
        while (const std::size_t size = reader.read(bytes.data(), bytes.size()))
            body += size;
        require(body <= RequestReader::kMostBody);
        count += body;
    }
    require(count <= sent.size());
    connections.ends(socket);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    if (size < 2) return 0;
    const std::string_view sent(reinterpret_cast<const char*>(data + 1), size - 1);
    const std::size_t piece = 1 + data[0] * std::size_t(data[0]);
    std::array<int, 2> ends{};
    require(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0);
    for (std::size_t at = 0; at < sent.size(); at += piece) {
        const std::string_view part = sent.substr(at, piece);
        if (::send(ends[1], part.data(), part.size(), MSG_DONTWAIT) != ssize_t(part.size())) break;
    }
    ::shutdown(ends[1], SHUT_WR);
    readAll(ends[0], sent);
    ::close(ends[0]);
    ::close(ends[1]);
    return 0;
}
