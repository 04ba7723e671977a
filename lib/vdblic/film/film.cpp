#include "vdblic/film/film.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/paging.h"
#include "vdblic/core/threads.h"
#include "vdblic/field/domain_mask.h"
#include "vdblic/film/film_cost.h"
#include "vdblic/film/film_import.h"
#include "vdblic/film/film_plan.h"
#include "vdblic/film/tool_process.h"
#include "vdblic/image/film_writer.h"
#include "vdblic/image/vector_text.h"
#include "vdblic/io/atomic_file.h"
#include "vdblic/io/file_stamp.h"
#include "vdblic/io/output_lock.h"
#include "vdblic/io/output_pattern.h"
#include "vdblic/look/look_preset.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/render_sequence.h"
#include "vdblic/render/view.h"
#include "vdblic/run/advect.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTitle = "vdblic_film: textures of a film that is not finished\n";

/// The textures of an unfinished film, with a text that names their inputs and options.
class FilmFolder {
  public:
    explicit FilmFolder(const fs::path& output) : mFolder(output.string() + ".textures"), mKey(mFolder / "film.txt") {}

    [[nodiscard]] std::string stem() const { return (mFolder / "").string(); } ///< of texturesOf()
    [[nodiscard]] const fs::path& path() const { return mFolder; }

    /// Make the folder, or keep its textures if their inputs and options are the same. @throws OutputError
    void open(const std::string& madeFrom, Reporter& reporter)
    {
        const std::string key = std::string(kTitle) + madeFrom;
        std::error_code error;
        if (fs::exists(mFolder, error)) {
            std::ifstream file;
            if (isFinished(mKey)) file.open(mKey, std::ios::binary);
            const std::string known(std::istreambuf_iterator<char>(file), {});
            if (known == key) return reporter.say(fmt::format("{}: going on with its textures", mFolder.string()));
            if (!known.starts_with(kTitle) && !fs::is_empty(mFolder, error)) {
                throw OutputError(fmt::format("{}: holds files that are not of a film; move it, or name the film "
                                              "otherwise",
                                              mFolder.string()));
            }
            if (known.starts_with(kTitle))
                reporter.say(fmt::format("{}: its textures are of other options or inputs and are made again",
                                         mFolder.string()));
            remove();
        }
        fs::create_directory(mFolder, error);
        if (error) throw OutputError(fmt::format("{}: cannot be made: {}", mFolder.string(), error.message()));
        writeTextFile(mKey, key);
    }

    /// Remove the film's files, and the folder if no other file is in it.
    void remove() const
    {
        std::error_code ignored;
        std::vector<fs::path> ours;
        for (const fs::directory_entry& entry : fs::directory_iterator(mFolder, ignored)) {
            const std::string name = entry.path().filename().string();
            if (isTexture(entry.path()) || name.starts_with("checkpoint.") || name.starts_with(".texture."))
                ours.push_back(entry.path());
        }
        ours.push_back(mKey); // last: without it the folder would not be known again
        for (const fs::path& file : ours)
            fs::remove(file, ignored);
        fs::remove(mFolder, ignored);
    }

    [[nodiscard]] bool hasTextures() const
    {
        std::error_code ignored;
        for (const fs::directory_entry& entry : fs::directory_iterator(mFolder, ignored)) {
            if (isTexture(entry.path())) return true;
        }
        return false;
    }

  private:
    static bool isTexture(const fs::path& path) { return path.filename().string().starts_with("texture."); }

    fs::path mFolder, mKey;
};

/// Joins the progress of textures and pictures, and passes on the film's messages.
class FilmReporter : public Reporter {
  public:
    FilmReporter(Reporter& reporter, std::size_t total, fs::path output)
        : mReporter(reporter), mTotal(total), mOutput(std::move(output))
    {
    }

    void begin(std::size_t before) { mBefore = before; } ///< @param before textures that are done

    void progress(std::size_t done, std::size_t) override { mReporter.progress(mBefore + done, mTotal); }
    void detail(std::string_view message) override { mReporter.detail(message); }
    void say(std::string_view message) override { mReporter.detail(message); }
    void warn(std::string_view message) override { mReporter.warn(message); }
    void finished(const fs::path& output) override
    {
        if (output == mOutput) mReporter.finished(output);
    }
    [[nodiscard]] bool stopRequested() const override { return mReporter.stopRequested(); }

  private:
    Reporter& mReporter;
    std::size_t mTotal, mBefore = 0;
    fs::path mOutput;
};

/// The parameters that a plan gives. @param params with their defaults
template<typename Params>
Params withGiven(Params params, const Given& given)
{
    set(parametersOf(params), given);
    return params;
}

/// Check, before any work, that the output can be written.
void checkFilm(const FilmParams& params)
{
    checkNotInput(params.output, params.input.pattern);
    checkOutput(params.output);
    if (params.isPage()) (void)findTool(std::string(kPageTool));
    constexpr glm::ivec2 kSmall{2, 2};
    if (params.isFilm()) FilmWriter(params.output, kSmall, params.picturesPerSecond()); // there is ffmpeg
}

/// Make the textures, then of them the output. @param stem of texturesOf()
void makeOutput(const FilmParams& params, const FilmPlan& plan, const std::string& stem, Reporter& reporter)
{
    const std::size_t runs = plan.runs.size();
    FilmReporter film(reporter, runs * plan.textures + plan.pictures, params.output);
    std::istringstream none;
    const auto makeTextures = [&] {
        for (std::size_t i = 0; i < runs; ++i) {
            film.begin(i * plan.textures);
            AdvectParams run = withGiven(AdvectParams{}, advectOf(plan, stem, i));
            run.resume = run.keepCheckpoint = true; // kept: all textures may be there, and the film not
            advectSequence(run, none, film);
        }
    };
    if (params.isPage()) {
        makeTextures();
        Words words = plan.page;
        words.insert(words.begin(), texturesOf(stem, 0));
        runTool(std::string(kPageTool), words, reporter);
        return reporter.finished(params.output);
    }
    const RenderParams pictures = withGiven(RenderParams{}, renderOf(plan, stem));
    // The pictures can use little of the memory that the textures free.
    constexpr double kPictures = 40e6; // without textures
    paging::makeRoom(plan.textureBytes + kPictures +
                     double(threadCount()) * bytesPerVoxel(resolve(pictures).picture) * plan.textureVoxels);
    makeTextures();
    film.begin(runs * plan.textures);
    renderSequence(pictures, none, film);
}

/// Make a film of a sequence on disk. @param imported the sequence, or null if it is the user's
void makeFrom(const FilmParams& params, const ImportedVelocity* imported, Reporter& reporter)
{
    const std::vector<FrameFile> files = selectFrames(params.input);
    for (const FrameFile& file : files)
        checkNotInput(params.output, file.path);
    const fs::path output(params.output);
    SequenceInfoParams inspection;
    inspection.flow.input = params.input;
    inspection.flow.observer = params.observer;
    inspection.values = true;
    const FilmPlan plan = planFilm(params, inspectSequence(inspection, reporter));
    for (const std::string& note : plan.notes)
        reporter.say(note);
    const char* const what = params.isFilm() ? "film" : params.isStill() ? "still" : "page";
    reporter.detail(fmt::format("the {} takes about {}", what, costText(plan)));
    std::vector<std::string> commands = commandsOf(plan, (output.parent_path() / output.stem()).string() + '.');
    std::string madeFrom;
    for (std::size_t run = 0; run < plan.runs.size(); ++run) // the pictures' options do not change textures
        madeFrom += commands[run] + '\n';
    if (imported) {
        for (std::string& command : commands)
            command = imported->asTyped(command);
        commands.insert(commands.begin(), imported->command());
    }
    constexpr std::array kNumbers{"two", "three", "four"};
    reporter.say(fmt::format("the same in {} commands:", kNumbers.at(commands.size() - 2)));
    for (const std::string& command : commands)
        reporter.say("  " + command);
    for (const FrameFile& file : files)
        madeFrom += fmt::format("{} {}\n", file.path.string(), fileStamp(file.path));

    FilmFolder folder(output);
    folder.open(madeFrom, reporter);
    reporter.say(fmt::format("textures wait in {} until the {} is done", folder.path().string(), what));
    try {
        makeOutput(params, plan, folder.stem(), reporter);
    } catch (...) {
        if (!folder.hasTextures()) {
            folder.remove();
        } else {
            reporter.say(fmt::format("{}: keeps the finished textures; the same command goes on with them",
                                     folder.path().string()));
        }
        throw;
    }
    folder.remove();
}

constexpr int kMostSide = 32768;

} // namespace

void makeFilm(const FilmParams& params, Reporter& reporter)
{
    params.validate();
    checkFilm(params);
    const fs::path output(params.output);
    const OutputLock claim(output.parent_path() / fmt::format(".{}.lock", output.filename().string()), output);
    if (!needsImport(params)) return makeFrom(params, nullptr, reporter);
    const ImportedVelocity velocity(params, reporter);
    FilmParams imported = params;
    imported.input.pattern = velocity.pattern();
    makeFrom(imported, &velocity, reporter);
    velocity.remove();
}

Parameters parametersOf(FilmParams& params)
{
    const Parameters sequence = parametersOf(params.input, "VELOCITY",
                                             "Velocity sequence: one file, or a pattern (name.%04d.vdb, also ####, "
                                             "@@@@, $F4, <F4>); or what vdblic_import reads.");
    Parameter look = parameter("look", "Look of the pictures; by default streaks, of dense textures flow.", params.look,
                               {.words = "NAME"});
    look.choices = lookPresetNames();
    const Parameters own = {
        *find(sequence, "input"),
        parameter("output", "Film, .mp4, still of the middle frame, .png, or page for browsers, .html.", params.output,
                  {.option = "-o,--output", .isRequired = true}),
        parameter("globe", "Place a file of longitude and latitude on a globe, as vdblic_import --globe does.",
                  params.globe),
        *find(sequence, "frames"),
        parameter("seconds", "Length of the film; by default what suits the flow, 5 to 10.", params.seconds,
                  {.unit = "s", .limits = {0.1, 3600}}),
        parameter("fps", "Pictures of the film a second; 24 by default.", params.fps, {.limits = {0.01, 1000}}),
        parameter("size", "Size of the pictures.", params.size,
                  {.unit = "pixels", .words = "W H", .limits = {2, kMostSide}}),
        look,
        parameter("view", "Side that the flow is seen from. Where north is +y, south is the front and east the right.",
                  params.view, {.words = "SIDE"}),
        parameter("angles", "The view by its height above the horizon, and its turn from the front to the right.",
                  params.angles,
                  {.unit = "degrees", .words = "ELEVATION AZIMUTH", .limits = {-360, 360}, .excludes = "view"}),
        viewFromParameter(params.angles, params.view),
        parameter("solid", "Opaque body, as of vdblic_render; by default what the flow leaves out of its box.",
                  params.solid, {.words = "FILE[:GRID] or domain"}),
        parameter("solid_color", "Colour of the body as displayed.", params.solidColor,
                  {.words = "R G B", .limits = {0, 1}}),
        parameter("plain", "Pictures without colour bar, time and scale bar.", params.plain),
        parameter("orbit", "Turns of the camera around the flow during the film.", params.orbit,
                  {.unit = "turns", .limits = {-100, 100}}),
        periodicParameter(params.periodic),
        parameter("preview", "Half the width and height, half the pictures, coarser textures: a first look.",
                  params.preview),
        parameter("method",
                  "Streaks show which way the flow goes, a dense texture fills every voxel; both: streaks in a dense "
                  "texture.",
                  params.method, {.words = "NAME"}),
    };
    return joined({own, parametersOf(params.observer)});
}

bool FilmParams::isFilm() const
{
    return std::filesystem::path(output).extension() == ".mp4";
}

bool FilmParams::isStill() const
{
    return std::filesystem::path(output).extension() == ".png";
}

bool FilmParams::isPage() const
{
    return std::filesystem::path(output).extension() == ".html";
}

glm::ivec2 FilmParams::pictureSize() const
{
    const auto side = [&](int given) { return preview ? std::max(given / 2, 1) : given; };
    return {side(size[0]), side(size[1])};
}

double FilmParams::picturesPerSecond() const
{
    return fps.value_or(preview ? 12 : 24);
}

void FilmParams::validate() const
{
    FilmParams copy = *this;
    checkLimits(parametersOf(copy));
    checkExtension(output, {".mp4", ".png", ".html"});
    observer.validate();
    if (input.pattern == "-")
        throw ParameterError("paths on standard input cannot be planned; name a file or a pattern");
    if (globe && !needsImport(*this))
        throw ParameterError("`globe` is of files for vdblic_import, and a .vdb lies where it is: leave it out");
    if (!look.empty()) (void)lookPreset(look);
    if (!isFilm() && (seconds || fps || orbit != 0))
        throw ParameterError("`seconds`, `fps` and `orbit` are of films: leave them out, or write an .mp4");
    if (!isPage()) return;
    if (method != FilmMethod::kStreaks)
        throw ParameterError(
            fmt::format("`method` {} makes no lines alone, and pages show nothing else: leave it out, or "
                        "write an .mp4",
                        nameOf(method)));
    if (!look.empty() || plain || angles || view != FilmParams{}.view || solidColor != FilmParams{}.solidColor) {
        throw ParameterError("`look`, `view`, `angles`, `plain` and `solid_color` are of pictures: leave them out, or "
                             "write an .mp4");
    }
}

} // namespace vdblic
