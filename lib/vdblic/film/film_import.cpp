#include "vdblic/film/film_import.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/printable.h"
#include "vdblic/film/tool_process.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/file_stamp.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <vector>

namespace vdblic {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTool = "vdblic_import";

/// A text that names the input's files and the options.
std::string keyOf(const std::vector<std::string>& arguments)
{
    std::string key;
    for (const std::string& argument : arguments)
        key += argument + '\n';
    std::error_code ignored;
    std::vector<fs::path> files = {arguments.front()};
    if (const FramePattern pattern(arguments.front()); pattern.hasField()) {
        files.clear();
        for (const std::int64_t frame : pattern.framesOnDisk())
            files.push_back(pattern.path(frame));
    } else if (fs::is_directory(files.front(), ignored)) {
        files = {fs::recursive_directory_iterator(files.front()), {}};
    }
    for (const fs::path& file : files)
        if (fs::is_regular_file(file, ignored)) key += fmt::format("{} {}\n", file.string(), fileStamp(file));
    return key;
}

} // namespace

bool needsImport(const FilmParams& params)
{
    return params.input.pattern != "-" && fs::path(params.input.pattern).extension() != ".vdb";
}

ImportedVelocity::ImportedVelocity(const FilmParams& params, Reporter& reporter)
    : mFolder(params.output + ".velocity"), mKey(mFolder / "import.txt"),
      mPattern((mFolder / "velocity.%04d.vdb").string()),
      mBeside(fs::path(params.output).replace_extension("velocity.%04d.vdb").string()),
      mCommand(fmt::format("{} {} -o {}{}", kTool, shellWord(params.input.pattern), shellWord(mBeside),
                           params.globe ? " --globe" : ""))
{
    std::vector<std::string> arguments = {params.input.pattern, "-o", mPattern};
    if (params.globe) arguments.emplace_back("--globe");
    if (!params.input.frames.empty()) arguments.insert(arguments.end(), {"--frames", params.input.frames});
    const std::string key = keyOf(arguments);
    if (isComplete(key)) {
        reporter.say(fmt::format("{}: going on with its velocity", mFolder.string()));
        return;
    }
    remove();
    std::error_code error;
    fs::create_directory(mFolder, error);
    if (error) throw OutputError(fmt::format("{}: cannot be made: {}", mFolder.string(), error.message()));
    try {
        runTool(kTool, arguments, reporter);
        writeTextFile(mKey, key);
    } catch (const InputError& fault) {
        remove();
        if (std::string_view(fault.what()).find("--") == std::string_view::npos) throw;
        throw InputError(fmt::format("{}; to give it options, run {} and then vdblic_film on "
                                     "its sequence",
                                     fault.what(), kTool));
    } catch (...) {
        remove();
        throw;
    }
}

bool ImportedVelocity::isComplete(const std::string& key) const
{
    std::ifstream file(mKey, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {}) == key;
}

std::string ImportedVelocity::asTyped(std::string command) const
{
    const auto stem = [](const std::string& pattern) { return pattern.substr(0, pattern.find("%04d.vdb")); };
    const std::string from = stem(mPattern), to = stem(mBeside);
    for (std::size_t at = 0; (at = command.find(from, at)) != std::string::npos; at += to.size())
        command.replace(at, from.size(), to);
    return command;
}

void ImportedVelocity::remove() const
{
    std::error_code ignored;
    fs::remove(mKey, ignored); // first: without it no sequence is complete
    const FramePattern frames(mPattern);
    for (const fs::directory_entry& entry : fs::directory_iterator(mFolder, ignored)) {
        if (frames.frameOf(entry.path())) fs::remove(entry.path(), ignored);
    }
    fs::remove(mFolder, ignored);
}

} // namespace vdblic
