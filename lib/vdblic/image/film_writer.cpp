#include "vdblic/image/film_writer.h"

#include "vdblic/core/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <functional>
#include <spawn.h>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

namespace vdblic {
namespace {

/// A pipe's two ends, which programs started later do not inherit.
std::array<int, 2> makePipe()
{
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
        throw OutputError(fmt::format("no pipe to ffmpeg: {}", std::generic_category().message(errno)));
    return ends;
}

std::uint64_t bigEndian(const unsigned char* bytes, std::size_t count)
{
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < count; ++i)
        number = number << 8 | bytes[i];
    return number;
}

/// Visit the boxes of an .mp4 file (ISO/IEC 14496-12) between two places.
/// @param visit called with a box's type and the begin and end of its content
/// @return whether they fill the space between
template<typename Visit>
bool visitBoxes(std::ifstream& file, std::uint64_t begin, std::uint64_t end, const Visit& visit)
{
    while (begin < end) {
        std::array<unsigned char, 16> head{};
        const std::uint64_t least = 8, most = std::min<std::uint64_t>(end - begin, head.size());
        file.seekg(std::streamoff(begin));
        if (most < least || !file.read(reinterpret_cast<char*>(head.data()), std::streamsize(most))) return false;
        std::uint64_t size = bigEndian(head.data(), 4), headSize = least;
        if (size == 1 && most == head.size()) { // follows in 64 bits
            size = bigEndian(head.data() + 8, 8);
            headSize = head.size();
        }
        if (size < headSize || size > end - begin) return false;
        visit(std::string(reinterpret_cast<const char*>(head.data()) + 4, 4), begin + headSize, begin + size);
        begin += size;
    }
    return true;
}

/// The reason why a file cannot grow, such as a full disk, which ffmpeg does not report. Empty if it can.
std::string writeFault(const std::filesystem::path& path)
{
    const int file = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    if (file < 0) return std::generic_category().message(errno);
    constexpr std::array<char, 4096> kBlock{};
    errno = ENOSPC; // of a write that is cut short
    const bool isWritten = ::write(file, kBlock.data(), kBlock.size()) == ssize_t(kBlock.size()) && ::fsync(file) == 0;
    const std::string fault = isWritten ? "" : std::generic_category().message(errno);
    ::close(file);
    return fault;
}

/// The number of frames of an .mp4 film; 0 if it is incomplete.
std::uint64_t framesIn(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const std::streamoff size = file.tellg();
    if (size <= 0) return 0;
    std::uint64_t frames = 0;
    bool hasData = false;
    const std::function<void(const std::string&, std::uint64_t, std::uint64_t)> visit =
        [&](const std::string& type, std::uint64_t begin, std::uint64_t end) {
            hasData = hasData || type == "mdat";
            if (type == "moov" || type == "trak" || type == "mdia" || type == "minf" || type == "stbl") {
                (void)visitBoxes(file, begin, end, visit);
            } else if (type == "stsz" && end - begin >= 12) {
                std::array<unsigned char, 12> table{}; // version, size of all frames, number of frames
                file.seekg(std::streamoff(begin));
                file.read(reinterpret_cast<char*>(table.data()), std::streamsize(table.size()));
                frames = bigEndian(table.data() + 8, 4);
            }
        };
    const bool isWhole = visitBoxes(file, 0, std::uint64_t(size), visit);
    return isWhole && hasData ? frames : 0;
}

} // namespace

FilmWriter::FilmWriter(const std::filesystem::path& path, const glm::ivec2& size, double framesPerSecond)
    : mPath(path), mFile(path, AtomicFile::Temporary::kNamed),
      mFrameBytes(3 * std::size_t(size.x) * std::size_t(size.y))
{
    // A fixed number of threads, so that the film does not depend on the machine.
    std::vector<std::string> words = {"ffmpeg",
                                      "-loglevel",
                                      "error",
                                      "-y",
                                      "-f",
                                      "rawvideo",
                                      "-pixel_format",
                                      "rgb24",
                                      "-video_size",
                                      fmt::format("{}x{}", size.x, size.y),
                                      "-framerate",
                                      fmt::format("{}", framesPerSecond),
                                      "-i",
                                      "pipe:0",
                                      "-vf",
                                      "pad=ceil(iw/2)*2:ceil(ih/2)*2,format=yuv420p",
                                      "-c:v",
                                      "libx264",
                                      "-crf",
                                      "20",
                                      "-threads",
                                      "4",
                                      "-fflags",
                                      "+bitexact",
                                      "-flags:v",
                                      "+bitexact",
                                      "-movflags",
                                      "+faststart",
                                      "-f",
                                      "mp4",
                                      mFile.temporary().string()};
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const auto [input, toInput] = makePipe();
    const auto [fromMessages, messages] = makePipe();
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
    // In a group of its own ffmpeg does not get the terminal's signals: this process decides when it ends.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    const int error = ::posix_spawnp(&mProcess, arguments[0], &actions, &attributes, arguments.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    ::close(input);
    ::close(messages);
    mInput = toInput;
    mMessages = fromMessages;
    if (error == 0) {
        rlimit data{}; // lifts the tool's own limit: ffmpeg may need more
        ::getrlimit(RLIMIT_DATA, &data);
        data.rlim_cur = data.rlim_max;
        ::prlimit(mProcess, RLIMIT_DATA, &data, nullptr);
        return;
    }
    mProcess = -1;
    close();
    throw OutputError(
        fmt::format("{}: ffmpeg, which makes films, cannot be started: {}; install it, or make images and "
                    "join them elsewhere",
                    path.string(), std::generic_category().message(error)));
}

FilmWriter::~FilmWriter()
{
    if (mProcess > 0) ::kill(mProcess, SIGKILL);
    close();
}

void FilmWriter::add(std::string_view bytes)
{
    mBytes += bytes.size();
    while (!bytes.empty()) {
        const ssize_t written = ::write(mInput, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail();
        bytes.remove_prefix(std::size_t(written));
    }
}

void FilmWriter::finish()
{
    ::close(std::exchange(mInput, -1));
    int status = 0;
    while (::waitpid(mProcess, &status, 0) < 0 && errno == EINTR) {
    }
    mProcess = -1;
    if (status != 0 || framesIn(mFile.temporary()) != mBytes / mFrameBytes) fail();
    close();
    mFile.commit();
}

/// Throw ffmpeg's message.
void FilmWriter::fail()
{
    ::close(std::exchange(mInput, -1));
    std::string text;
    std::array<char, 1024> part{};
    ssize_t count = 0;
    do {
        count = ::read(mMessages, part.data(), part.size());
        text.append(part.data(), std::size_t(std::max<ssize_t>(count, 0)));
    } while (text.size() < 4096 && (count > 0 || (count < 0 && errno == EINTR)));
    while (!text.empty() && text.back() == '\n')
        text.pop_back();
    const std::string fault = writeFault(mFile.temporary());
    throw OutputError(fmt::format("{}: ffmpeg cannot write the film: {}", mPath.string(),
                                  !fault.empty() ? fault
                                  : text.empty() ? "what it wrote is incomplete; the disk may be full"
                                                 : text.substr(text.rfind('\n') + 1)));
}

/// Close the pipes, and wait for ffmpeg.
void FilmWriter::close()
{
    for (int* end : {&mInput, &mMessages}) {
        if (*end >= 0) ::close(std::exchange(*end, -1));
    }
    while (mProcess > 0 && ::waitpid(mProcess, nullptr, 0) < 0 && errno == EINTR) {
    }
    mProcess = -1;
}

} // namespace vdblic
