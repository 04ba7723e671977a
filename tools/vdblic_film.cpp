#include "cli/joined_numbers.h"
#include "cli/tool.h"
#include "vdblic/film/film.h"

int main(int argc, char** argv)
{
    vdblic::FilmParams params;
    vdblic::cli::Tool tool("vdblic_film", "Make a film, or a still, from a velocity sequence.");
    tool.options(parametersOf(params));
    constexpr double kInFiles = 8; // bricks and light of a texture, or frames of velocity and the state
    tool.usesScratch(kInFiles, [&] { return params.output; });
    vdblic::cli::JoinedNumbers arguments(argc, argv, {"--frame-velocity"});
    return tool.run(arguments.count(), arguments.arguments(), [&](vdblic::Reporter& reporter) {
        warnOfOtherNumbers(params.input, reporter);
        makeFilm(params, reporter);
    });
}
