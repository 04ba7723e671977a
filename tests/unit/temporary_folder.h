#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

namespace vdblic {

/// A fresh folder for a test's files, removed with all its contents at the end.
class TemporaryFolder {
  public:
    TemporaryFolder()
    {
        std::string name = (std::filesystem::temp_directory_path() / "vdblic-XXXXXX").string();
        if (!::mkdtemp(name.data())) throw std::runtime_error("cannot make " + name);
        mPath = name;
    }
    ~TemporaryFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(mPath, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return mPath; }
    [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return mPath / name; }

    /// Make a file in the folder.
    std::filesystem::path add(const std::string& name, const std::string& text = "") const
    {
        std::ofstream(mPath / name) << text;
        return mPath / name;
    }
    [[nodiscard]] bool empty() const { return std::filesystem::is_empty(mPath); }

  private:
    std::filesystem::path mPath;
};

} // namespace vdblic
