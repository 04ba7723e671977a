#include "cli/picture_options.h"
#include "cli/ranks.h"
#include "cli/shared_frames.h"
#include "cli/tool.h"
#include "vdblic/core/errors.h"
#include "vdblic/render/frames_in_flight.h"
#include "vdblic/render/render_sequence.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <vector>

int main(int argc, char** argv)
{
    vdblic::RenderParams params;
    const vdblic::cli::Ranks ranks = vdblic::cli::startRanks(argc, argv);
    vdblic::cli::Tool tool(ranks.toolName("vdblic_render"), "Ray cast flow textures into images.");
    tool.share(ranks);
    CLI::App& app = tool.app();
    tool.inputSequence("TEXTURE", params.input, "Texture volumes.");
    tool.skipExisting(params.skipExisting);
    app.add_flag("--keep-going", params.keepGoing,
                 "Leave out frames that cannot be read; the exit status tells at the end.");
    app.add_option(
        "-o,--output", params.output,
        "Image or pattern of images, .exr (linear, premultiplied alpha) or .png (8 bit sRGB, opaque). May be "
        "left out with --histogram or --transfer-out.");
    const vdblic::cli::PictureOptions picture(app, params);
    std::vector<std::string> layers;
    app.add_option("--aov", layers,
                   "Further channels of .exr: depth, normal, magnitude, texture, samples, or all; NAME,NAME.")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("NAME");
    tool.option("--precision", params.exr.precision, "Of colour and alpha in .exr: half or float.");
    tool.option("--compression", params.exr.compression,
                fmt::format("Of .exr: {}.", fmt::join(vdblic::exrCompressions(), ", ")));
    app.add_option("--histogram", params.histogram,
                   "Histograms of texture and scalars with the transfer function over them, .png or .json.");
    app.add_option("--transfer-out", params.transferOut,
                   "JSON file for the range, colours and opacity that are rendered with, for --transfer.");
    app.add_option("--film", params.film, "Film of all frames, .mp4, made by ffmpeg; -o may be left out.");
    tool.option("--fps", params.framesPerSecond, "Frames of the film a second.");
    tool.verifies([&] { return std::vector<vdblic::SequenceParams>{params.input}; });
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) {
        picture.apply();
        params.exr.layers = vdblic::parseImageLayers(layers);
        params.rays.layers = !params.exr.layers.empty();
        if (!ranks.exchange->isAlone() && (!params.film.empty() || !params.histogram.empty())) {
            throw vdblic::ParameterError(
                "a film or a histogram is of all frames, which no rank has: leave it out here, "
                "and make it by vdblic_render");
        }
        if (!ranks.exchange->isFirst()) params.transferOut.clear();
        if (vdblic::ranksShareFrames(params, *ranks.exchange))
            return vdblic::renderSequence(params, tool.standardInput(), reporter, *ranks.exchange);
        vdblic::cli::shareFrames(*ranks.exchange, params.input, reporter,
                                 [&](const vdblic::SequenceParams& input, vdblic::Reporter& to) {
                                     vdblic::RenderParams share = params;
                                     share.input = input;
                                     vdblic::renderSequence(share, tool.standardInput(), to);
                                 });
    });
}
