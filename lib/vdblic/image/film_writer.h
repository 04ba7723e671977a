#pragma once

#include "vdblic/io/atomic_file.h"

#include <glm/vec2.hpp>

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <sys/types.h>

namespace vdblic {

/// An .mp4 film (H.264), written frame by frame through a pipe to ffmpeg. It appears under its name when it is
/// complete; without finish() no file remains.
class FilmWriter {
  public:
    /// @throws OutputError if there is no ffmpeg, or the folder is not writable
    FilmWriter(const std::filesystem::path& path, const glm::ivec2& size, double framesPerSecond);
    ~FilmWriter();
    FilmWriter(const FilmWriter&) = delete;
    FilmWriter& operator=(const FilmWriter&) = delete;

    /// @param bytes as displayBytes() returns them. @throws OutputError with ffmpeg's reason
    void add(std::string_view bytes);
    /// @throws OutputError with ffmpeg's reason, also if it ended well and the film is incomplete, as on a full disk
    void finish();

  private:
    [[noreturn]] void fail();
    void close();

    std::filesystem::path mPath;
    AtomicFile mFile;
    pid_t mProcess = -1;
    std::size_t mFrameBytes, mBytes = 0; // of a frame, and of all added ones
    int mInput = -1, mMessages = -1;     // pipes to ffmpeg and from its standard error
};

} // namespace vdblic
