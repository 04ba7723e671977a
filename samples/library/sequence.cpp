// Makes a sequence of an analytic flow and its textures, as vdblic_synth and vdblic_advect do. Prints the finished
// files.
#include <vdblic/core/errors.h>
#include <vdblic/core/reporter.h>
#include <vdblic/field/synth.h>
#include <vdblic/run/advect.h>

#include <filesystem>
#include <iostream>
#include <sstream>

class Printer : public vdblic::Reporter {
  public:
    void finished(const std::filesystem::path& output) override { std::cout << output.string() << '\n'; }
    void warn(std::string_view message) override { std::cerr << message << '\n'; }
};

int main()
{
    try {
        Printer printer;
        vdblic::synthSequence({.flow = "tornado", .output = "v.%04d.vdb", .size = {{32, 32, 32}}, .frames = "1-4"},
                              printer);
        vdblic::AdvectParams params;
        params.flow.input.pattern = "v.%04d.vdb";
        params.output = "lic.%04d.vdb";
        params.texture.lifeSpan = 3;
        std::istringstream noPaths; // for the pattern `-`
        vdblic::advectSequence(params, noPaths, printer);
    } catch (const vdblic::Error& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
}
