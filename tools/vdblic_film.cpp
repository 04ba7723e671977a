#include "cli/tool.h"
#include "vdblic/film/film.h"

int main(int argc, char** argv)
{
    vdblic::FilmParams params;
    vdblic::cli::Tool tool("vdblic_film", "Make a film, or a still, from a velocity sequence.");
    tool.options(parametersOf(params));
    return tool.run(argc, argv, [&](vdblic::Reporter& reporter) { vdblic::makeFilm(params, reporter); });
}
