#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::view {

/// A request that has passed the checks.
struct WebRequest {
    std::string method; ///< GET or POST
    std::string path;   ///< below the token, without a slash in front
    std::string body;
    std::function<bool()> isGone; ///< whether the client has closed the connection
};

struct WebAnswer {
    int status = 200;
    std::string type, body;
    std::vector<std::pair<std::string, std::string>> headers{};
};

/// A small web server for a few people, which trusts no client.
///
/// Whoever asks must know the token, which begins every path. The Host header must be an address, localhost, or the
/// name that the server was given, and the Origin header, if there is one, the same host: other sites' pages get
/// nothing, even if their name leads here (DNS rebinding). Heads, bodies, connections and the time for each are
/// limited. A connection ends with a request that is refused, so that no body is taken for the next request. Of too
/// many connections the one that has waited longest for its client is closed.
class WebServer {
  public:
    using Handler = std::function<WebAnswer(const WebRequest&)>;

    /// Bind the port; serve() answers. @param port 0: any free one
    /// @param writing time for an answer from its first byte on, however long the handler takes
    /// @throws ParameterError if host and port cannot be bound
    WebServer(const std::string& host, int port, std::string token, Handler handler,
              std::chrono::milliseconds writing = std::chrono::seconds(30));
    ~WebServer();
    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    [[nodiscard]] int port() const;
    /// Answer requests until stop(), which another thread calls.
    void serve();
    void stop();

  private:
    class Server;
    std::unique_ptr<Server> mServer;
};

/// 128 random bits as text.
[[nodiscard]] std::string randomToken();

} // namespace vdblic::view
