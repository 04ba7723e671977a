#include "view/web_server.h"

#include "vdblic/core/errors.h"
#include "view/request_check.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/random.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <exception>
#include <functional>
#include <list>
#include <optional>
#include <system_error>
#include <utility>

namespace vdblic::view {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using asio::ip::tcp;
using boost::beast::error_code;

constexpr std::size_t kMostConnections = 48, kMostRequests = 1000;                    // on a connection
constexpr std::size_t kAnswering = 16;                                                // threads; further requests wait
constexpr std::size_t kMostHead = 32 << 10, kMostBody = 1 << 20, kMostRead = 4 << 10; // bytes; the last at once
constexpr std::chrono::seconds kIdle{30}, kMostTime{10}, kLinger{1};                  // kMostTime for a whole request
constexpr std::size_t kStack = 1 << 20;                                               // bytes, of a thread
constexpr int kBacklog = 256;

constexpr std::array<std::pair<const char*, const char*>, 6> kHeaders{
    {{"Content-Security-Policy", "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
                                 "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
     {"X-Content-Type-Options", "nosniff"},
     {"Referrer-Policy", "no-referrer"},
     {"Cross-Origin-Resource-Policy", "same-origin"},
     {"Cross-Origin-Opener-Policy", "same-origin"},
     {"Cache-Control", "no-store"}}};

/// Give threads that are started from now on small stacks, which count against a limit on memory. @return kAnswering
std::size_t threadsOfSmallStacks()
{
    pthread_attr_t attributes;
    ::pthread_attr_init(&attributes);
    ::pthread_attr_setstacksize(&attributes, kStack);
    ::pthread_setattr_default_np(&attributes);
    ::pthread_attr_destroy(&attributes);
    return kAnswering;
}

bool isGone(int socket)
{
    pollfd state{socket, POLLRDHUP, 0};
    return ::poll(&state, 1, 0) > 0 && (state.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

} // namespace

/// One thread runs everything but the handler.
class WebServer::Server {
  public:
    Server(const std::string& host, int port, std::string token, WebServer::Handler handler,
           std::chrono::milliseconds writing)
        : mCheck(host, std::move(token)), mHandler(std::move(handler)), mWriting(writing)
    {
        const auto found = tcp::resolver(mContext).resolve(host, std::to_string(port), tcp::resolver::passive);
        const tcp::endpoint endpoint = *found.begin();
        mAcceptor.open(endpoint.protocol());
        mAcceptor.set_option(tcp::acceptor::reuse_address(true));
        if (endpoint.address().is_v6()) mAcceptor.set_option(asio::ip::v6_only(false));
        mAcceptor.bind(endpoint);
        mAcceptor.listen(kBacklog);
    }

    [[nodiscard]] int port() const { return mAcceptor.local_endpoint().port(); }

    void serve()
    {
        accept();
        while (!mContext.stopped()) {
            try {
                mContext.run();
            } catch (const std::exception&) { // ends one connection: memory that is short, say
            }
        }
        mThreads.join();
    }

    void stop()
    {
        asio::post(mContext, [this] {
            mEnds = true;
            mAcceptor.close();
            mPause.cancel();
            for (const std::list<Connection*> reading = mReading; Connection * connection : reading)
                connection->close();
        });
    }

  private:
    class Connection : public std::enable_shared_from_this<Connection> {
      public:
        Connection(Server& server, tcp::socket socket) : mServer(server), mStream(std::move(socket))
        {
            ++mServer.mOpen;
        }
        ~Connection() { leave(); }
        Connection(const Connection&) = delete;
        Connection& operator=(const Connection&) = delete;

        /// Read the next request. Its time begins with its first byte.
        void read()
        {
            mParser.emplace();
            mParser->header_limit(kMostHead);
            mParser->body_limit(kMostBody);
            mServer.mReading.push_back(this);
            mServer.closeTooMany();
            if (mBuffer.size() > 0) return readHead();
            mStream.expires_after(kIdle);
            mStream.async_read_some(mBuffer.prepare(kMostRead),
                                    [self = shared_from_this()](const error_code& error, std::size_t count) {
                                        self->mBuffer.commit(count);
                                        if (!error) self->readHead();
                                    });
        }

        /// @return whether everything that came was read
        [[nodiscard]] bool isIdle()
        {
            error_code ignored;
            return mStream.socket().available(ignored) == 0;
        }

        void close()
        {
            leave();
            mStream.close();
        }

      private:
        /// Count no more.
        void leave()
        {
            mServer.mReading.remove(this);
            if (std::exchange(mCounts, false)) --mServer.mOpen;
        }

        void readHead()
        {
            mStream.expires_after(kMostTime);
            http::async_read_header(mStream, mBuffer, *mParser,
                                    [self = shared_from_this()](const error_code& error, std::size_t) {
                                        if (error) return self->refuseBroken(error);
                                        self->readBody();
                                    });
        }

        void readBody()
        {
            if (std::optional<WebAnswer> refused = mServer.mCheck.refusalOf(*mParser))
                return refuse(std::move(*refused));
            http::async_read(mStream, mBuffer, *mParser,
                             [self = shared_from_this()](const error_code& error, std::size_t) {
                                 if (error) return self->refuseBroken(error);
                                 self->answer();
                             });
        }

        void refuseBroken(const error_code& error)
        {
            if (error == http::error::body_limit) return refuse(refusal(413, "the request is too large"));
            if (error.category() == make_error_code(http::error::bad_method).category() &&
                error != http::error::end_of_stream && error != http::error::partial_message) {
                refuse(refusal(400, "the request is broken"));
            }
        }

        void refuse(WebAnswer answer)
        {
            mRequests = kMostRequests;
            write(std::move(answer));
        }

        void answer()
        {
            mServer.mReading.remove(this);
            mStream.expires_never();
            auto& request = mParser->get();
            WebRequest asked{std::string(request.method_string()), mServer.mCheck.pathOf(request),
                             std::move(request.body()),
                             [socket = mStream.socket().native_handle()] { return isGone(socket); }};
            // A connection is freed by the thread that serves, so the one that answers gives it back.
            asio::post(mServer.mThreads, [self = shared_from_this(), asked = std::move(asked),
                                          work = asio::make_work_guard(mServer.mContext)]() mutable {
                Server& server = self->mServer;
                asio::post(server.mContext, [answer = server.mHandler(asked), self = std::move(self)]() mutable {
                    self->write(std::move(answer));
                });
            });
        }

        void write(WebAnswer answer)
        {
            mServer.mReading.remove(this);
            mAnswer = {http::status(answer.status), 11, std::move(answer.body)};
            for (const auto& [name, value] : kHeaders)
                mAnswer.set(name, value);
            for (const auto& [name, value] : answer.headers)
                mAnswer.set(name, value);
            if (!answer.type.empty()) mAnswer.set(http::field::content_type, answer.type);
            mAnswer.keep_alive(mParser->is_done() && mParser->keep_alive() && ++mRequests < kMostRequests &&
                               !mServer.mEnds);
            mAnswer.prepare_payload();
            mStream.expires_after(mServer.mWriting);
            http::async_write(mStream, mAnswer, [self = shared_from_this()](const error_code& error, std::size_t) {
                if (error) return;
                self->mAnswer.keep_alive() && !self->mServer.mEnds ? self->read() : self->end();
            });
        }

        /// Read for a while what the client still sends: the end of a connection with unread bytes takes the answer
        /// with it.
        void end()
        {
            error_code ignored;
            mStream.socket().shutdown(tcp::socket::shutdown_send, ignored);
            if (mServer.mEnds) return;
            mServer.mReading.push_front(this);
            mStream.expires_after(kLinger);
            passOver();
        }

        void passOver()
        {
            mBuffer.clear();
            mStream.async_read_some(mBuffer.prepare(kMostRead),
                                    [self = shared_from_this()](const error_code& error, std::size_t) {
                                        if (!error) self->passOver();
                                    });
        }

        Server& mServer;
        boost::beast::tcp_stream mStream;
        boost::beast::flat_buffer mBuffer;
        std::optional<RequestCheck::Parser> mParser;
        http::response<http::string_body> mAnswer;
        std::size_t mRequests = 0;
        bool mCounts = true;
    };

    void accept()
    {
        mAcceptor.async_accept([this](const error_code& error, tcp::socket socket) {
            if (mEnds) return;
            if (error) { // no more descriptors, say
                mPause.expires_after(std::chrono::milliseconds(100));
                return mPause.async_wait([this](const error_code&) {
                    if (!mEnds) accept();
                });
            }
            error_code ignored;
            socket.set_option(tcp::no_delay(true), ignored);
            std::make_shared<Connection>(*this, std::move(socket))->read();
            accept();
        });
    }

    /// Close those that have waited longest for their clients. What a client has sent is read before, or its request
    /// would be lost.
    void closeTooMany()
    {
        for (auto next = mReading.begin(); mOpen > kMostConnections && next != mReading.end();) {
            Connection* connection = *next++;
            if (connection->isIdle()) connection->close();
        }
    }

    RequestCheck mCheck;
    WebServer::Handler mHandler;
    std::chrono::milliseconds mWriting;
    std::size_t mOpen = 0;
    std::list<Connection*> mReading; // the one that has waited longest first
    bool mEnds = false;
    asio::io_context mContext{1};
    tcp::acceptor mAcceptor{mContext};
    asio::steady_timer mPause{mContext}; // before connections are accepted again
    asio::thread_pool mThreads{threadsOfSmallStacks()};
};

WebServer::WebServer(const std::string& host, int port, std::string token, Handler handler,
                     std::chrono::milliseconds writing)
try : mServer(std::make_unique<Server>(host, port, std::move(token), std::move(handler), writing)) {
} catch (const boost::system::system_error& error) {
    if (error.code() == boost::system::errc::resource_unavailable_try_again) throw std::system_error(error.code());
    throw ParameterError(fmt::format("`port` {} of `host` {} cannot be used; another program may have it, or the "
                                     "host is none of this machine's addresses",
                                     port, host));
}

WebServer::~WebServer() = default;

int WebServer::port() const
{
    return mServer->port();
}

void WebServer::serve()
{
    mServer->serve();
}

void WebServer::stop()
{
    mServer->stop();
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
