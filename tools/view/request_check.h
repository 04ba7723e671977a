#pragma once

#include "view/web_server.h"

#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

#include <optional>
#include <string>

namespace vdblic::view {

/// The answer that tells why a request is refused.
[[nodiscard]] WebAnswer refusal(int status, const char* reason);

/// Which requests are answered: only this server's own page's (its token, host and site), with an unambiguous length.
class RequestCheck {
  public:
    using Parser = boost::beast::http::request_parser<boost::beast::http::string_body>;

    /// @param host that is served  @param token that every target begins with
    RequestCheck(std::string host, std::string token);

    /// Check the head of a request. @return the answer to one that does not pass
    [[nodiscard]] std::optional<WebAnswer> refusalOf(const Parser& parser) const;
    /// The target of a request that passes, without token and query.
    [[nodiscard]] std::string pathOf(const Parser::value_type& request) const;

  private:
    std::string mHost, mToken;
};

} // namespace vdblic::view
