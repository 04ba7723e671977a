#include "view/request_check.h"

#include <boost/asio/ip/address.hpp>
#include <fmt/format.h>

#include <cstddef>
#include <string_view>
#include <utility>

namespace vdblic::view {
namespace {

namespace http = boost::beast::http;

std::string textOf(boost::beast::string_view text)
{
    return {text.data(), text.size()};
}

/// The host in a Host header, without the port and the brackets of IPv6.
std::string hostName(std::string_view header)
{
    if (header.starts_with('[')) return std::string(header.substr(1, header.find(']') - 1));
    return std::string(header.substr(0, header.rfind(':')));
}

bool isAddress(const std::string& host)
{
    boost::system::error_code isNone;
    (void)boost::asio::ip::make_address(host, isNone);
    return !isNone;
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

} // namespace

WebAnswer refusal(int status, const char* reason)
{
    return {status, "text/plain; charset=utf-8", fmt::format("{}\n", reason)};
}

RequestCheck::RequestCheck(std::string host, std::string token) : mHost(std::move(host)), mToken(std::move(token)) {}

std::optional<WebAnswer> RequestCheck::refusalOf(const Parser& parser) const
{
    const Parser::value_type& request = parser.get();
    const auto header = [&](http::field name) { return textOf(request[name]); };
    const std::string origin = header(http::field::origin), site = textOf(request["Sec-Fetch-Site"]);
    const std::string host = hostName(header(http::field::host)), target = textOf(request.target());
    if (request.count(http::field::host) != 1 || (host != "localhost" && host != mHost && !isAddress(host))) {
        return refusal(421, "the Host header names another host");
    }
    if ((!origin.empty() && origin != "http://" + header(http::field::host)) ||
        (!site.empty() && site != "same-origin" && site != "none")) {
        return refusal(403, "the request comes from another site");
    }
    const bool isGet = request.method() == http::verb::get;
    if (!isGet && request.method() != http::verb::post) return refusal(405, "only GET and POST are answered");
    if (target.size() > 200 || target.size() < mToken.size() + 2 ||
        !equalInConstantTime(target.substr(1, mToken.size() + 1), mToken + "/")) {
        return refusal(403, "the address lacks the token; copy all of what vdblic_view printed");
    }
    const bool isInChunks = parser.chunked();
    if (request.count(http::field::content_length) > 1 ||
        (isGet ? isInChunks || parser.content_length().value_or(0) != 0 : !isInChunks && !parser.content_length())) {
        return refusal(400, "a POST has one length or comes in chunks, and a GET has no body");
    }
    if (!isGet && (header(http::field::content_type) != "application/json" ||
                   request.count(http::field::content_encoding) != 0)) {
        return refusal(415, "the body must be application/json");
    }
    return std::nullopt;
}

std::string RequestCheck::pathOf(const Parser::value_type& request) const
{
    const std::string target = textOf(request.target());
    return target.substr(0, target.find('?')).substr(mToken.size() + 2);
}

} // namespace vdblic::view
