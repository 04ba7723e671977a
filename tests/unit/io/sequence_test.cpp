#include "vdblic/io/sequence.h"

#include "temporary_folder.h"
#include "vdblic/core/errors.h"
#include "vdblic/io/output_pattern.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <sstream>
#include <utility>

namespace vdblic {
namespace {

using Frames = std::vector<std::int64_t>;

std::string nameOf(const char* pattern, std::int64_t frame)
{
    return FramePattern(pattern).path(frame).string();
}

/// The message of an error; empty if none of the type is thrown.
template<typename ErrorT, typename Call>
std::string messageOf(const Call& call)
{
    try {
        call();
    } catch (const ErrorT& error) {
        return error.what();
    }
    return {};
}

void expectContains(const std::string& text, const std::string& part)
{
    EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
}

TEST(FramePattern, NamesFramesInAllFiveForms)
{
    for (const char* pattern :
         {"out/v.%04d.vdb", "out/v.####.vdb", "out/v.@@@@.vdb", "out/v.$F4.vdb", "out/v.<F4>.vdb"}) {
        EXPECT_TRUE(FramePattern(pattern).hasField());
        EXPECT_EQ(nameOf(pattern, 12), "out/v.0012.vdb") << pattern;
        EXPECT_EQ(nameOf(pattern, 123456), "out/v.123456.vdb") << pattern;
        EXPECT_EQ(nameOf(pattern, 0), "out/v.0000.vdb") << pattern;
        EXPECT_EQ(nameOf(pattern, -12), "out/v.-012.vdb") << pattern;
        EXPECT_EQ(nameOf(pattern, -12345), "out/v.-12345.vdb") << pattern;
    }
    for (const char* pattern : {"v%d.vdb", "v#.vdb", "v@.vdb", "v$F.vdb", "v<F>.vdb", "v%01d.vdb", "v$F1.vdb"}) {
        EXPECT_EQ(nameOf(pattern, 7), "v7.vdb") << pattern;
        EXPECT_EQ(nameOf(pattern, 77), "v77.vdb") << pattern;
        EXPECT_EQ(nameOf(pattern, -7), "v-7.vdb") << pattern;
    }
    EXPECT_EQ(nameOf("%012d", 5), "000000000005");
}

TEST(FramePattern, CompanionsAreNoFrames)
{
    for (const auto& [pattern, name] : {std::pair("out/lic.%04d.vdb", "out/note.lic.vdb"),
                                        {"lic_####.vdb", "note.lic.vdb"},
                                        {"lic$F4.vdb", "note.lic.vdb"},
                                        {"%04d.vdb", "note.vdb"},
                                        {"%04d_lic.vdb", "note_lic.vdb"},
                                        {"lic.vdb", "note.lic.vdb"}}) {
        EXPECT_EQ(FramePattern(pattern).companion("note"), name);
    }
    const TemporaryFolder folder;
    folder.add("note.vdb");
    EXPECT_EQ(FramePattern((folder / "%d.vdb").string()).framesOnDisk(), Frames{});
}

TEST(FramePattern, NamesCoarserCopies)
{
    EXPECT_EQ(FramePattern("a/lic.%04d.vdb").ofLevel(2).path(7), "a/lic.level2.0007.vdb");
    EXPECT_EQ(FramePattern("<F3>_b.vdb").ofLevel(1).path(7), "level1.007_b.vdb");
    EXPECT_EQ(FramePattern("a/lic.vdb").ofLevel(1).path(7), "a/lic.level1.vdb");
}

TEST(FramePattern, PadsAsPrintfDoes)
{
    for (const int width : {1, 2, 3, 4, 8}) {
        for (const int frame : {0, 1, 9, 10, 999, 100000, -1, -10, -999}) {
            char expected[32];
            std::snprintf(expected, sizeof(expected), "%0*d", width, frame);
            EXPECT_EQ(FramePattern("%0" + std::to_string(width) + "d").path(frame).string(), expected);
        }
    }
}

TEST(FramePattern, WithoutFieldIsOneFile)
{
    for (const char* name :
         {"v.vdb", "a folder/v (1) [x] 100%.vdb", "v.0001.vdb", "$HOME.vdb", "<frame>.vdb", "%4x.vdb"}) {
        EXPECT_FALSE(FramePattern(name).hasField()) << name;
        EXPECT_EQ(nameOf(name, 5), name);
    }
}

TEST(FramePattern, RefusesWhatIsAmbiguous)
{
    for (const char* pattern :
         {"%04d_%04d.vdb", "v.####.@@@@.vdb", "v#.v#", "$F4<F4>", "%d/v.vdb", "sim.%04d/v.vdb", "sim.$F4/v.%04d.vdb",
          "<F4>/v.vdb", "", "folder/", "%021d.vdb", "$F99.vdb", "<F0>.vdb"}) {
        EXPECT_THROW(FramePattern{pattern}, ParameterError) << pattern;
    }
    // Characters that are common in folder names are not fields there.
    EXPECT_EQ(nameOf("shot #3/user@host/v.%02d.vdb", 4), "shot #3/user@host/v.04.vdb");
}

TEST(FramePattern, AFileOfTheVeryNameIsMeantAsItIs)
{
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.add("take #2.vdb");
    EXPECT_FALSE(FramePattern(file.string()).hasField());
    EXPECT_EQ(FramePattern(file.string()).path(9), file);
    EXPECT_TRUE(FramePattern((folder / "take #3.vdb").string()).hasField());
}

TEST(FramePattern, FindsExactlyTheFilesItNames)
{
    const TemporaryFolder folder;
    for (const char* name :
         {"v 2 [a].0002.vdb", "v 2 [a].0010.vdb", "v 2 [a].-003.vdb", "v 2 [a].12345.vdb",   // these
          "v 2 [a].7.vdb", "v 2 [a].00008.vdb", "v 2 [a].0009.vdb.part", "v 2 [b].0004.vdb", // not these
          "v 2 [a].00x5.vdb", "v 2 [a]..vdb", "v 2 [a].vdb", ".v 2 [a].0006.vdb", "v 2 [a].+005.vdb",
          "v 2 [a]. 006.vdb", "xv 2 [a].0007.vdb", "v 2 [a].99999999999999999999.vdb"}) {
        folder.add(name);
    }
    EXPECT_EQ(FramePattern((folder / "v 2 [a].%04d.vdb").string()).framesOnDisk(), (Frames{-3, 2, 10, 12345}));
    EXPECT_EQ(FramePattern((folder / "v 2 [a].#.vdb").string()).framesOnDisk(), (Frames{7, 12345}));
    EXPECT_EQ(FramePattern((folder / "v 2 [a].<F5>.vdb").string()).framesOnDisk(), (Frames{8, 12345}));
    EXPECT_THROW((void)FramePattern((folder / "none/v.%04d.vdb").string()).framesOnDisk(), InputError);
}

TEST(SelectFrames, TakesWhatIsOnDiskOrWhatIsAsked)
{
    const TemporaryFolder folder;
    for (const char* name : {"v.0001.vdb", "v.0003.vdb", "v.0005.vdb", "v.0009.vdb"})
        folder.add(name);
    const std::string pattern = (folder / "v.%04d.vdb").string();
    const std::vector<FrameFile> files = selectFrames({pattern, "1-5x2"});
    ASSERT_EQ(files.size(), 3u);
    EXPECT_EQ(files[1].frame, 3);
    EXPECT_EQ(files[1].path, folder / "v.0003.vdb");

    expectContains(messageOf<InputError>([&] { (void)selectFrames({pattern, "1-5"}); }), "frame 2 is missing");
    expectContains(messageOf<InputError>([&] { (void)selectFrames({pattern, "1-5"}); }), "v.0002.vdb");
    // The frames found are two apart, so 7 is missing.
    expectContains(messageOf<InputError>([&] { (void)selectFrames({pattern, ""}); }), "frame 7 is missing");
    folder.add("v.0007.vdb");
    EXPECT_EQ(selectFrames({pattern, ""}).size(), 5u);
    EXPECT_THROW((void)selectFrames({(folder / "w.%04d.vdb").string(), ""}), InputError);
    // A folder with a frame's name is not a frame.
    std::filesystem::create_directory(folder / "v.0011.vdb");
    EXPECT_THROW((void)selectFrames({pattern, "11"}), InputError);
}

TEST(SelectFrames, TakesOneFile)
{
    const TemporaryFolder folder;
    const std::string numbered = folder.add("smoke_0042.vdb").string(), plain = folder.add("smoke.vdb").string();
    ASSERT_EQ(selectFrames({numbered, ""}).size(), 1u);
    EXPECT_EQ(selectFrames({numbered, ""})[0].frame, 42);
    EXPECT_EQ(selectFrames({plain, ""})[0].frame, 1);
    EXPECT_EQ(selectFrames({plain, ""})[0].path, plain);
    expectContains(messageOf<ParameterError>([&] { (void)selectFrames({plain, "1-3"}); }), "`frames`");
    expectContains(messageOf<InputError>([&] { (void)selectFrames({plain + "x", ""}); }), "smoke.vdbx");
    expectContains(messageOf<ParameterError>([&] {
                       (void)selectFrames({folder.path().string(), ""});
                   }),
                   "it is a folder");
}

TEST(OpenSequence, ReadsPathsFromAStream)
{
    const TemporaryFolder folder;
    const std::string a = folder.add("a.0007.vdb").string(), b = folder.add("b.vdb").string();
    const std::string c = folder.add("c.3.vdb").string();
    std::istringstream lines(a + "\n\n" + c);
    std::size_t count = 99;
    const FrameSource next = openSequence({"-", ""}, lines, count);
    EXPECT_EQ(count, 0u);
    for (const auto& [frame, path] : {std::pair(7, a), std::pair(3, c)}) {
        const std::optional<FrameFile> file = next();
        ASSERT_TRUE(file);
        EXPECT_EQ(file->frame, frame);
        EXPECT_EQ(file->path, path);
    }
    EXPECT_FALSE(next());

    for (const std::string& second : {b, a}) { // no number, and the same number
        std::istringstream unusable(fmt::format("{}\r\n{}\r\n", a, second));
        const FrameSource source = openSequence({"-", ""}, unusable, count);
        EXPECT_EQ(source()->frame, 7);
        EXPECT_THROW((void)source(), InputError);
        std::istringstream again(fmt::format("{}{}{}{}", a, '\0', second, '\0'));
        const FrameSource numbered = openSequence({"-", "", false, -1}, again, count);
        for (const int frame : {-1, 0})
            EXPECT_EQ(numbered()->frame, frame);
        EXPECT_FALSE(numbered());
    }
    EXPECT_THROW((void)openSequence({c, "", false, 1}, lines, count), ParameterError);

    std::istringstream missing(a + "\n" + (folder / "none.vdb").string() + "\n");
    const FrameSource broken = openSequence({"-", ""}, missing, count);
    EXPECT_TRUE(broken());
    EXPECT_THROW((void)broken(), InputError);
    EXPECT_THROW((void)openSequence({"-", "1-3"}, missing, count), ParameterError);
}

TEST(OpenSequence, ReadsPathsAsTheyCome)
{
    const TemporaryFolder folder;
    std::stringstream lines;
    lines << folder.add("a.0001.vdb").string() << "\n";
    std::size_t count = 0;
    const FrameSource next = openSequence({"-", ""}, lines, count);
    EXPECT_EQ(next()->frame, 1);
    lines << (folder / "a.0002.vdb").string() << "\n"; // appears after the first was returned
    folder.add("a.0002.vdb");
    const std::optional<FrameFile> second = next();
    ASSERT_TRUE(second);
    EXPECT_EQ(second->frame, 2);
}

TEST(OpenSequence, GoesThroughAPattern)
{
    const TemporaryFolder folder;
    for (const char* name : {"v.1.vdb", "v.2.vdb", "v.10.vdb"})
        folder.add(name);
    std::istringstream unused;
    std::size_t count = 0;
    const FrameSource next = openSequence({(folder / "v.#.vdb").string(), "1,2,10"}, unused, count);
    EXPECT_EQ(count, 3u);
    for (const std::int64_t frame : {1, 2, 10})
        EXPECT_EQ(next()->frame, frame);
    EXPECT_FALSE(next());
    EXPECT_FALSE(next());
}

struct Warnings : Reporter {
    void warn(std::string_view message) override { texts.emplace_back(message); }
    std::vector<std::string> texts;
};

std::vector<std::string> warningsOf(const SequenceParams& params)
{
    Warnings warnings;
    warnOfOtherNumbers(params, warnings);
    return warnings.texts;
}

TEST(OtherNumbers, OfAnotherWidthAreNamed)
{
    const TemporaryFolder folder;
    for (const char* name : {"v.998.vdb", "v.999.vdb", "v.1000.vdb", "v.1001.vdb", "v.rest.vdb", "v.level1.1000.vdb"})
        folder.add(name);
    const SequenceParams params{(folder / "v.%04d.vdb").string(), ""};
    EXPECT_EQ(FramePattern(params.pattern).otherNumbersOnDisk(), (std::vector<std::string>{"v.998.vdb", "v.999.vdb"}));
    const std::vector<std::string> warned = warningsOf(params);
    ASSERT_EQ(warned.size(), 1u);
    expectContains(warned[0], "v.%04d.vdb leaves out v.998.vdb and 1 more");
    expectContains(warned[0], "v.%03d.vdb");
    EXPECT_EQ(selectedFrames({(folder / "v.%03d.vdb").string(), ""}), (Frames{998, 999, 1000, 1001}));
    EXPECT_TRUE(warningsOf({(folder / "v.%03d.vdb").string(), ""}).empty());
    EXPECT_TRUE(warningsOf({params.pattern, "1000"}).empty()); // chosen
    expectContains(messageOf<InputError>([&] { (void)selectFrames({params.pattern, "999-1001"}); }), "v.998.vdb");
}

TEST(OtherNumbers, SubframesAreNamed)
{
    const TemporaryFolder folder;
    for (const char* name : {"v.1001.00.vdb", "v.1001.25.vdb"})
        folder.add(name);
    const SequenceParams params{(folder / "v.%04d.vdb").string(), ""};
    const std::string message = messageOf<InputError>([&] { (void)selectFrames(params); });
    expectContains(message, "it leaves out v.1001.00.vdb and 1 more");
    expectContains(message, "`renumber`");
    folder.add("v.1001.vdb");
    EXPECT_EQ(selectedFrames(params), Frames{1001});
    EXPECT_EQ(warningsOf(params).size(), 1u);
}

TEST(SelectFrames, TakesBothSpellingsOfNegativeNumbers)
{
    const TemporaryFolder folder;
    for (const char* name : {"a.-0003.vdb", "a.-0002.vdb", "a.0000.vdb", "b.-003.vdb", "b.-0003.vdb"})
        folder.add(name);
    const std::vector<FrameFile> files = selectFrames({(folder / "a.%04d.vdb").string(), "-3,-2,0"});
    ASSERT_EQ(files.size(), 3u);
    EXPECT_EQ(files[0].path.filename(), "a.-0003.vdb");
    EXPECT_EQ(files[1].path.filename(), "a.-0002.vdb");
    EXPECT_EQ(FramePattern((folder / "a.$F4.vdb").string()).framesOnDisk(), (Frames{-3, -2, 0}));
    const FramePattern both((folder / "b.%04d.vdb").string());
    EXPECT_EQ(both.framesOnDisk(), Frames{-3});
    EXPECT_EQ(both.path(-3).filename(), "b.-003.vdb");
    EXPECT_EQ(both.otherNumbersOnDisk(), std::vector<std::string>{"b.-0003.vdb"});
}

TEST(FrameOfName, ReadsTheNumberAtTheEnd)
{
    EXPECT_EQ(frameOfName("a/smoke_0012.vdb"), 12);
    EXPECT_EQ(frameOfName("smoke2.0012.vdb"), 12);
    EXPECT_EQ(frameOfName("0012.vdb"), 12);
    EXPECT_EQ(frameOfName("v.0000.vdb"), 0);
    EXPECT_EQ(frameOfName("v.-012.vdb"), -12);
    EXPECT_EQ(frameOfName("v_-12.vdb"), -12);
    EXPECT_EQ(frameOfName("-12.vdb"), -12);
    EXPECT_EQ(frameOfName("sim-12.vdb"), 12);
    EXPECT_EQ(frameOfName("v.999999999999.vdb"), 999999999999);
    for (const char* name : {"v.vdb", "v12x.vdb", "12/v.vdb", "", "v.1234567890123.vdb", "v.-.vdb",
                             "wrfout_d01_2005-08-28_00:00:00", "era5_2005-08-28.vdb", "a_2005-8-1.vdb", "12:30.vdb"}) {
        EXPECT_EQ(frameOfName(name), std::nullopt) << name;
    }
}

TEST(CheckOutputPattern, WantsAFieldForSeveralFrames)
{
    EXPECT_NO_THROW(checkOutputPattern(FramePattern("v.vdb"), 1));
    EXPECT_NO_THROW(checkOutputPattern(FramePattern("v.%d.vdb"), 5));
    EXPECT_THROW(checkOutputPattern(FramePattern("v.vdb"), 2), ParameterError);
    EXPECT_THROW(checkOutputPattern(FramePattern("v.vdb"), 0), ParameterError); // the number of frames is unknown
}

} // namespace
} // namespace vdblic
