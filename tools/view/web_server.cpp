#include "view/web_server.h"

#include "vdblic/core/errors.h"
#include "view/connection.h"

#include <fmt/format.h>
#include <httplib.h>
#include <pthread.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <optional>
#include <poll.h>
#include <string_view>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

namespace vdblic::view {
namespace {

constexpr std::size_t kMostConnections = 48; // one thread each
constexpr int kBacklog = 256;
constexpr std::size_t kMostRequests = 1000; // on a connection
constexpr std::chrono::seconds kIdle{30};
constexpr std::size_t kStack = 1 << 20; // bytes, of a connection's thread

thread_local int socketOfThread = -1; // of the connection that the thread serves
thread_local bool hasRefused = false; // a request of the connection

/// A connection as httplib reads and writes it.
class ConnectionStream : public httplib::Stream {
  public:
    ConnectionStream(int socket, RequestReader& reader, std::chrono::milliseconds writing)
        : mSocket(socket), mReader(reader), mWriting(writing)
    {
    }

    bool is_readable() const override { return true; }
    bool is_writable() const override { return true; }
    ssize_t read(char* bytes, std::size_t count) override { return ssize_t(mReader.read(bytes, count)); }
    ssize_t write(const char* bytes, std::size_t count) override
    {
        const auto now = std::chrono::steady_clock::now();
        if (!mDeadline) mDeadline = now + mWriting;
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(*mDeadline - now);
        pollfd state{mSocket, POLLOUT, 0};
        if (left.count() <= 0 || ::poll(&state, 1, int(left.count())) <= 0) return -1;
        return ::send(mSocket, bytes, count, MSG_NOSIGNAL | MSG_DONTWAIT);
    }
    void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
    void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
    socket_t socket() const override { return mSocket; }

    /// The time for writing will begin with the first byte of the answer.
    void begin() { mDeadline.reset(); }

  private:
    int mSocket;
    RequestReader& mReader;
    std::chrono::milliseconds mWriting;
    std::optional<std::chrono::steady_clock::time_point> mDeadline;
};

/// A thread for each connection.
class ConnectionQueue : public httplib::TaskQueue {
  public:
    explicit ConnectionQueue(Connections& connections) : mConnections(connections), mThreads(kMostConnections) {}

    void enqueue(std::function<void()> serve) override
    {
        mConnections.begins();
        mThreads.enqueue(std::move(serve));
    }
    void shutdown() override { mThreads.shutdown(); }

  private:
    Connections& mConnections;
    httplib::ThreadPool mThreads;
};

/// The host in a Host header, without the port and the brackets of IPv6.
std::string hostName(std::string_view header)
{
    if (header.starts_with('[')) return std::string(header.substr(1, header.find(']') - 1));
    return std::string(header.substr(0, header.rfind(':')));
}

bool isAddress(const std::string& host)
{
    std::array<unsigned char, sizeof(in6_addr)> bytes;
    return ::inet_pton(AF_INET, host.c_str(), bytes.data()) == 1 ||
           ::inet_pton(AF_INET6, host.c_str(), bytes.data()) == 1;
}

/// Whether two texts are equal, in a time that does not tell where they differ.
bool equalInConstantTime(std::string_view a, std::string_view b)
{
    if (a.size() != b.size()) return false;
    unsigned difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        difference |= unsigned(a[i]) ^ unsigned(b[i]);
    return difference == 0;
}

bool isGone(int socket)
{
    pollfd state{socket, POLLRDHUP, 0};
    return ::poll(&state, 1, 0) > 0 && (state.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

/// Whether nobody on the way can see a request of another length in it.
bool hasLengthOfItsMethod(const httplib::Request& request)
{
    const std::size_t lengths = request.get_header_value_count("Content-Length");
    const std::string length = request.get_header_value("Content-Length");
    const bool isInChunks = request.has_header("Transfer-Encoding");
    if (request.method == "GET") return !isInChunks && (lengths == 0 || (lengths == 1 && length == "0"));
    return isInChunks ? lengths == 0
                      : lengths == 1 && !length.empty() && length.find_first_not_of("0123456789") == std::string::npos;
}

void refuse(httplib::Response& response, int status, const char* reason)
{
    hasRefused = true;
    response.status = status;
    response.set_header("Connection", "close");
    response.set_content(fmt::format("{}\n", reason), "text/plain; charset=utf-8");
}

} // namespace

class WebServer::Server : public httplib::Server {
  public:
    Server(std::string host, std::string token, WebServer::Handler handler, std::chrono::milliseconds writing)
        : mHost(std::move(host)), mToken(std::move(token)), mHandler(std::move(handler)), mWriting(writing)
    {
        new_task_queue = [this] { return new ConnectionQueue(mConnections); };
        set_tcp_nodelay(true);
        set_idle_interval(0, 100000);
        set_keep_alive_max_count(kMostRequests);
        set_keep_alive_timeout(kIdle.count());
        set_default_headers({{"Content-Security-Policy",
                              "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
                              "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
                             {"X-Content-Type-Options", "nosniff"},
                             {"Referrer-Policy", "no-referrer"},
                             {"Cross-Origin-Resource-Policy", "same-origin"},
                             {"Cross-Origin-Opener-Policy", "same-origin"},
                             {"Cache-Control", "no-store"}});
        set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
            return passes(request, response) ? HandlerResponse::Unhandled : HandlerResponse::Handled;
        });
        Get(".*",
            [this](const httplib::Request& request, httplib::Response& response) { answer(request, {}, response); });
        Post(".*", [this](const httplib::Request& request, httplib::Response& response,
                          const httplib::ContentReader& reader) {
            std::string body;
            const bool read = reader([&](const char* bytes, std::size_t count) {
                body.append(bytes, count);
                return body.size() <= RequestReader::kMostBody;
            });
            if (read) return answer(request, std::move(body), response);
            refuse(response, 413, "the request is too large, too slow or broken");
        });
    }

    void begin()
    {
        ::listen(svr_sock_, kBacklog); // httplib has bound it with a backlog of 5, which loses connections
        listen_after_bind();
        mHasEnded = true;
    }

    /// A server that does not listen yet would miss the end.
    void end()
    {
        while (!is_running() && !mHasEnded)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        stop();
        mConnections.closeAll();
    }

    int port = 0;

  private:
    /// The checks of a request's head; writes the answer to one that does not pass.
    bool passes(const httplib::Request& request, httplib::Response& response) const
    {
        const std::string header = request.get_header_value("Host"), host = hostName(header);
        const std::string origin = request.get_header_value("Origin");
        const std::string site = request.get_header_value("Sec-Fetch-Site");
        if (request.get_header_value_count("Host") != 1 || (host != "localhost" && host != mHost && !isAddress(host))) {
            refuse(response, 421, "the Host header names another host");
        } else if ((!origin.empty() && origin != "http://" + header) ||
                   (!site.empty() && site != "same-origin" && site != "none")) {
            refuse(response, 403, "the request comes from another site");
        } else if (request.method != "GET" && request.method != "POST") {
            refuse(response, 405, "only GET and POST are answered");
        } else if (request.path.size() > 200 || request.path.size() < mToken.size() + 2 ||
                   !equalInConstantTime(request.path.substr(1, mToken.size() + 1), mToken + "/")) {
            refuse(response, 403, "the address lacks the token; copy all of what vdblic_view printed");
        } else if (!hasLengthOfItsMethod(request)) {
            refuse(response, 400, "a POST has one length or comes in chunks, and a GET has no body");
        } else if (request.method == "POST" && (request.get_header_value("Content-Type") != "application/json" ||
                                                request.has_header("Content-Encoding"))) {
            refuse(response, 415, "the body must be application/json");
        } else {
            return true;
        }
        return false;
    }

    void answer(const httplib::Request& request, std::string body, httplib::Response& response) const
    {
        const WebRequest asked{request.method, request.path.substr(mToken.size() + 2), std::move(body),
                               [socket = socketOfThread] { return isGone(socket); }};
        const WebAnswer given = mHandler(asked);
        response.status = given.status;
        for (const auto& [name, value] : given.headers)
            response.set_header(name, value);
        response.set_content(given.body, given.type);
    }

    bool process_and_close_socket(socket_t socket) override
    {
        socketOfThread = socket;
        hasRefused = false;
        RequestReader reader(socket, mConnections);
        ConnectionStream stream(socket, reader, mWriting);
        bool closed = false;
        for (std::size_t i = 0; i < kMostRequests && !closed && !hasRefused; ++i) {
            if (!is_running() || !reader.readHead(kIdle)) break;
            const auto begin = [&](httplib::Request&) { stream.begin(); };
            if (!process_request(stream, i + 1 == kMostRequests, closed, begin)) break;
        }
        mConnections.ends(socket);
        ::shutdown(socket, SHUT_RDWR);
        ::close(socket);
        return true;
    }

    std::string mHost, mToken;
    WebServer::Handler mHandler;
    std::chrono::milliseconds mWriting;
    Connections mConnections{kMostConnections};
    std::atomic<bool> mHasEnded = false;
};

WebServer::WebServer(const std::string& host, int port, std::string token, Handler handler,
                     std::chrono::milliseconds writing)
    : mServer(std::make_unique<Server>(host, std::move(token), std::move(handler), writing))
{
    const bool bound =
        port == 0 ? (mServer->port = mServer->bind_to_any_port(host)) > 0 : mServer->bind_to_port(host, port);
    if (port != 0) mServer->port = port;
    if (!bound) {
        throw ParameterError(fmt::format("`port` {} of `host` {} cannot be used; another program may have it, or the "
                                         "host is none of this machine's addresses",
                                         port, host));
    }
}

WebServer::~WebServer() = default;

int WebServer::port() const
{
    return mServer->port;
}

void WebServer::serve()
{
    pthread_attr_t attributes;
    ::pthread_attr_init(&attributes);
    ::pthread_attr_setstacksize(&attributes, kStack);
    ::pthread_setattr_default_np(&attributes);
    ::pthread_attr_destroy(&attributes);
    mServer->begin();
}

void WebServer::stop()
{
    mServer->end();
}

std::string randomToken()
{
    std::array<unsigned char, 16> bytes;
    if (::getrandom(bytes.data(), bytes.size(), 0) != ssize_t(bytes.size()))
        throw InputError("the system gives no random numbers for the token");
    std::string token;
    for (const unsigned char byte : bytes)
        token += fmt::format("{:02x}", byte);
    return token;
}

} // namespace vdblic::view
