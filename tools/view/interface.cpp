#include "view/interface.h"

#include "cli/option_names.h"
#include "vdblic/core/errors.h"
#include "vdblic/core/reporter.h"
#include "vdblic/image/color_map.h"
#include "vdblic/look/look_preset.h"
#include "vdblic/look/shading.h"
#include "vdblic/render/annotation_texts.h"
#include "view/page_files.h"
#include "view/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdblic::view {
namespace {

/// A message of the library in the words of the options.
std::string inOptions(std::string_view message)
{
    PictureParams params;
    return cli::withOptionNames(message, parametersOf(params));
}

using Json = nlohmann::json;

constexpr std::size_t kMostNext = 8; // frames to be read ahead

WebAnswer jsonAnswer(const Json& json, int status = 200)
{
    return {status, "application/json",
            json.dump(-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace) + "\n"};
}

WebAnswer errorAnswer(int status, const std::string& message)
{
    return jsonAnswer({{"error", inOptions(message)}}, status);
}

Json listOf(const glm::dvec3& v)
{
    return {v.x, v.y, v.z};
}

/// A colour as pages have it.
std::string hexText(const glm::dvec3& color)
{
    const auto byte = [](double share) { return std::lround(share * 255); };
    return fmt::format("#{:02x}{:02x}{:02x}", byte(color.r), byte(color.g), byte(color.b));
}

/// A member of a request. @throws ParameterError
template<typename T>
T member(const Json& asked, const char* name, const T& fallback)
{
    try {
        return asked.is_object() && asked.contains(name) ? asked.at(name).get<T>() : fallback;
    } catch (const Json::exception&) {
        throw ParameterError(fmt::format("\"{}\" has the wrong type", name));
    }
}

Json stateIn(const Json& asked)
{
    Json state = member(asked, "state", Json(Json::object()));
    if (!state.is_object()) throw ParameterError("\"state\" must be an object");
    return state;
}

Json toJson(const Camera& camera)
{
    return {{"projection", nameOf(camera.projection())},
            {"eye", listOf(camera.eye())},
            {"target", listOf(camera.target())},
            {"up", listOf(camera.up())},
            {"fov", camera.fieldOfView()},
            {"height", 2 * camera.halfExtent().y}};
}

/// The named colour maps, each with the colours of its evenly spaced stops.
Json colorMaps()
{
    Json maps = Json::array();
    for (const std::string& name : colorMapNames()) {
        Json colors = Json::array();
        for (const auto& [position, color] : colorMapPoints(name))
            colors.push_back(hexText(color));
        maps.push_back({{"name", name}, {"colors", colors}});
    }
    return maps;
}

/// @throws ParameterError
glm::dvec3 vectorIn(const Json& asked, const char* name)
{
    const auto numbers = member(asked, name, std::vector<double>());
    if (numbers.size() != 3) throw ParameterError(fmt::format("\"{}\" must be three numbers", name));
    return {numbers[0], numbers[1], numbers[2]};
}

Json toJson(const Histogram& histogram)
{
    return {{"low", histogram.low},
            {"high", histogram.high},
            {"scale", nameOf(histogram.scale)},
            {"counts", histogram.counts}};
}

/// A scalar's term with its unit. @param chosen by the transfer function, else `stored` in the grid
std::string titleOf(const std::string& name, const std::string& chosen, const std::string& stored)
{
    return scalarTitle(name, scalarUnit(name, chosen.empty() ? stored : chosen));
}

/// The numbers of a look as the options that set them, for controls to show. @param exposure that was chosen
Json valuesOf(const PicturePlan& plan, double exposure)
{
    const LookParams& look = plan.look;
    const Shading& shading = look.shading;
    return {{"modulate", look.textureStrength},
            {"limb-darkening", look.limbDarkening},
            {"halo", look.halo},
            {"shadows", look.shadows},
            {"occlusion", look.occlusion},
            {"depth-cue", look.depthCue},
            {"exposure", exposure},
            {"shading", nameOf(shading.model)},
            {"head-light", shading.headLight},
            {"step", plan.rays.step},
            {"background", listOf(plan.background.color)},
            {"background-top", listOf(plan.background.at(0))}};
}

} // namespace

WebAnswer Interface::answer(const WebRequest& request)
{
    try {
        return answerAsked(request);
    } catch (const Stopped&) {
        return errorAnswer(409, "a newer request took the place of this one");
    } catch (const ParameterError& error) {
        return errorAnswer(400, error.what());
    } catch (const InputError& error) {
        return errorAnswer(422, error.what());
    } catch (const OutputError& error) {
        return errorAnswer(507, error.what());
    } catch (const std::bad_alloc&) {
        return errorAnswer(503, "this takes more memory than may be used; raise `max_memory` or ask for less");
    } catch (const std::exception& error) {
        return errorAnswer(500, fmt::format("internal error, please report it: {}", error.what()));
    }
}

WebAnswer Interface::answerAsked(const WebRequest& request)
{
    if (request.method == "GET") {
        if (request.path == "sequence") return jsonAnswer(sequence());
        if (request.path == "status") return jsonAnswer(status());
        const auto file = pageFile(request.path.empty() ? "index.html" : request.path);
        if (!file) return errorAnswer(404, "there is no such page");
        return {200, std::string(file->type), std::string(file->bytes)};
    }
    const Json asked = Json::parse(
        request.body,
        [](int depth, Json::parse_event_t, const Json&) {
            if (depth > 16) throw ParameterError("the request is nested too deeply");
            return true;
        },
        /*allow_exceptions=*/false);
    if (!asked.is_object()) throw ParameterError("the request is no JSON object");
    const auto frame = member(asked, "frame", std::int64_t(0));
    if (request.path == "picture") return picture(asked, request);
    if (request.path == "lines") {
        std::string packet = mViewer.lines(stateIn(asked), frame);
        return {packet.empty() ? 204 : 200, "application/octet-stream", std::move(packet)};
    }
    if (request.path == "rest") {
        mPictures.end({.client = member(asked, "client", std::string()),
                       .turn = member(asked, "turn", std::int64_t(0)),
                       .state = {}});
        return jsonAnswer(Json::object());
    }
    if (request.path == "thumbnail")
        return {200, "image/jpeg",
                mPictures.thumbnail({.client = {}, .turn = {}, .state = stateIn(asked), .frame = frame})};
    if (request.path == "scene") return jsonAnswer(scene(stateIn(asked), frame));
    if (request.path == "keep") return jsonAnswer(keep(asked));
    if (request.path == "histograms") {
        const TextureHistograms found = mViewer.histograms(stateIn(asked));
        return jsonAnswer(
            {{"texture", toJson(found.texture)}, {"color", toJson(found.color)}, {"opacity", toJson(found.opacity)}});
    }
    if (request.path == "command")
        return jsonAnswer({{"command", commandOf(mViewer.start(), stateIn(asked), {"-o", "image.%04d.png"})}});
    if (request.path == "fit")
        return jsonAnswer(toJson(mViewer.fitted(stateIn(asked), vectorIn(asked, "forward"), vectorIn(asked, "up"))));
    if (request.path == "stop") {
        mKeeper.stop(member(asked, "job", std::int64_t(0)));
        return jsonAnswer(Json::object());
    }
    return errorAnswer(404, "there is no such page");
}

Json Interface::sequence()
{
    return {{"pattern", mViewer.start().input.pattern},
            {"folder", std::filesystem::current_path().string()},
            {"frames", mViewer.frames()},
            {"version", mViewer.version()},
            {"texture", mViewer.texture()},
            {"lines", mViewer.hasLines()},
            {"scalars", mViewer.scalars()},
            {"looks", lookPresetNames()},
            {"colorMaps", colorMaps()},
            {"solid", mViewer.start().solid},
            {"start", mViewer.start().state}};
}

Json Interface::status()
{
    Json jobs = mKeeper.jobs();
    for (Json& job : jobs)
        job["error"] = inOptions(job["error"].get_ref<const std::string&>());
    return {{"frames", mViewer.frames()}, {"version", mViewer.version()}, {"jobs", jobs}};
}

Json Interface::scene(const Json& state, std::int64_t frame)
{
    const FrameView view = mViewer.view(state, frame);
    const TransferFunction& transfer = view.view.look.transfer;
    const std::string colorBy = view.shown->frame().hasColor ? view.plan.colorBy : mViewer.texture();
    FrameClock clock = view.shown->frame().clock;
    clock.longest = view.view.longest;
    Json points = Json::array();
    for (const OpacityPoint& point : transfer.opacity())
        points.push_back({point.position, point.opacity});
    Json colors = Json::array();
    for (const auto& [position, color] : transfer.colors())
        colors.push_back({position, hexText(color)});
    Json corners = Json::array();
    for (const glm::dvec3& corner : view.view.box)
        corners.push_back(listOf(corner));
    return {
        {"settled", view.settled},
        {"clock", clockText(clock)},
        {"camera", toJson(view.view.cameras.at(double(frame)))},
        {"box", corners},
        {"stretch", listOf(view.plan.stretch)},
        {"colorBy", colorBy},
        {"colorTitle", titleOf(colorBy, transfer.params().unit, view.shown->frame().colorUnit)},
        {"opacityBy", view.view.opacityBy},
        {"opacityTitle", titleOf(view.view.opacityBy, transfer.params().opacityUnit, view.shown->frame().opacityUnit)},
        {"range", transfer.range()},
        {"opacityRange", transfer.opacityRange()},
        {"colorScale", nameOf(transfer.colorAxis().scale)},
        {"opacityScale", nameOf(transfer.opacityAxis().scale)},
        {"opacity", points},
        {"look", view.plan.lookName},
        {"colorMap", transfer.colorMapName()},
        {"colors", colors},
        {"values", valuesOf(view.plan, view.view.look.exposure)}};
}

Json Interface::keep(const Json& asked)
{
    const auto kind = member(asked, "kind", std::string());
    const auto frame = member(asked, "frame", std::int64_t(0));
    if (kind == "files") return mKeeper.keepFiles(stateIn(asked), frame);
    if (kind == "film") return mKeeper.beginFilm(stateIn(asked), member(asked, "fps", 24.0));
    if (kind != "picture") throw ParameterError("\"kind\" must be files, picture or film");
    return mKeeper.beginPicture(
        {.client = {}, .turn = std::nullopt, .state = stateIn(asked), .frame = frame, .settle = true},
        member(asked, "format", std::string("png")));
}

WebAnswer Interface::picture(const Json& asked, const WebRequest& request)
{
    PictureRequest wanted{.client = member(asked, "client", std::string()),
                          .turn = std::nullopt,
                          .state = stateIn(asked),
                          .frame = member(asked, "frame", std::int64_t(0)),
                          .settle = member(asked, "settle", false)};
    if (asked.contains("turn")) wanted.turn = member(asked, "turn", std::int64_t(0));
    const auto next = member(asked, "next", std::vector<std::int64_t>());
    if (wanted.client.size() > 64) throw ParameterError("\"client\" is too long");
    if (next.size() > kMostNext) throw ParameterError(fmt::format("\"next\" may have {} frames", kMostNext));
    const int quality = std::clamp(member(asked, "quality", 90), 1, 100);
    const bool lossless = member(asked, "format", std::string("jpeg")) == "png";
    std::optional<ShownPicture> made;
    try {
        made = mPictures.picture(wanted, request.isGone);
    } catch (const Stopped&) {
        return {204, "", ""}; // no error: browsers report those
    }
    const ShownPicture& shown = *made;
    for (const std::int64_t ahead : next)
        mViewer.prefetch(wanted.state, ahead);
    WebAnswer answer{200, lossless ? "image/png" : "image/jpeg",
                     lossless ? encodePng(shown.image, shown.background)
                              : encodeJpeg(displayBytes(shown.image, shown.background), shown.image.size, quality)};
    answer.headers = {{"Vdblic-Samples", std::to_string(shown.samples)},
                      {"Vdblic-Settled", shown.settled ? "1" : "0"},
                      {"Vdblic-Cast", fmt::format("{:.6f}", shown.castSeconds)}};
    if (!shown.nothingSeen.empty()) {
        const std::string reason = inOptions(shown.nothingSeen);
        answer.headers.emplace_back("Vdblic-Nothing", Json(reason).dump(-1, ' ', /*ensure_ascii=*/true));
    }
    return answer;
}

} // namespace vdblic::view
