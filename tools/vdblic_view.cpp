#include "cli/picture_groups.h"
#include "cli/tool.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/memory.h"
#include "vdblic/render/frames_in_flight.h"
#include "view/interface.h"
#include "view/web_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

namespace {

/// Serve until a stop is requested.
void serve(vdblic::view::WebServer& server, const vdblic::Reporter& reporter)
{
    std::thread serving([&] { server.serve(); });
    while (!reporter.stopRequested())
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    server.stop();
    serving.join();
}

/// Bytes for the cache of frames. Several viewers may run beside other work, so the default without a limit is small.
double cacheBytes(const CLI::App& app)
{
    constexpr double kUsual = 2e9;
    const double free = vdblic::availableMemory();
    return app.count("--max-memory") > 0 ? free / 2 : std::min(kUsual, free / 4);
}

bool isLoopback(const std::string& host)
{
    return host == "localhost" || host == "::1" || host.starts_with("127.");
}

} // namespace

int main(int argc, char** argv)
{
    vdblic::SequenceParams input;
    vdblic::PictureParams params;
    std::string host = "127.0.0.1";
    int port = 0;
    bool open = false;
    vdblic::cli::Tool tool("vdblic_view", "Find the picture of flow textures by hand, in a browser, and keep it.");
    CLI::App& app = tool.app();
    app.add_option("--port", port, "Port to listen on; 0: any free one.")
        ->capture_default_str()
        ->check(CLI::Range(0, 65535));
    app.add_option("--host", host,
                   "Address to listen on. Any but the default lets other machines in that know the address with its "
                   "token.")
        ->capture_default_str();
    app.add_flag("--open", open, "Open the page in a browser (xdg-open).");
    tool.options(
        vdblic::joined(
            {parametersOf(input, "TEXTURE",
                          "Texture volumes: one file or a pattern (name.%04d.vdb, also ####, @@@@, $F4, <F4>)."),
             parametersOf(params)}),
        vdblic::cli::pictureGroups({{"Lines", {"lines"}}}));
    constexpr double kInFiles = 8; // bricks and light of a texture
    tool.usesScratch(kInFiles);
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) {
        if (input.pattern == "-")
            throw vdblic::ParameterError("the viewer needs every frame at any time: name a file or a pattern, not -");
        warnOfOtherNumbers(input, reporter);
        const double cache = cacheBytes(app);
        reporter.detail(fmt::format("frames are kept in memory up to {}", vdblic::memoryText(cache)));
        vdblic::view::Viewer viewer(vdblic::view::startOf(tool.given(), input), cache);
        vdblic::view::Interface interface(viewer);
        const std::string token = vdblic::view::randomToken();
        vdblic::view::WebServer server(
            host, port, token, [&](const vdblic::view::WebRequest& request) { return interface.answer(request); });
        if (!isLoopback(host)) {
            reporter.warn(fmt::format("whoever reaches {} on port {} and knows the token sees the data and can write "
                                      "files view-* here; the connection is not encrypted",
                                      host, server.port()));
        }
        const std::string address = fmt::format(
            "http://{}:{}/{}/", host.find(':') == std::string::npos ? host : "[" + host + "]", server.port(), token);
        reporter.finished(address);
        if (const std::string advice = viewer.advice(); !advice.empty()) reporter.say(advice);
        reporter.say("the page is at the address on standard output; Ctrl-C ends");
        if (open && std::system(fmt::format("xdg-open '{}' >/dev/null 2>&1 &", address).c_str()) != 0)
            reporter.warn("xdg-open is not there; open the address by hand");
        serve(server, reporter);
        reporter.checkStop();
    });
}
