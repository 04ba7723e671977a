#pragma once

#include "vdblic/core/reporter.h"
#include "vdblic/film/film.h"

#include <filesystem>
#include <string>

namespace vdblic {

/// Whether the input is in a format of other programs, so that vdblic_import must read it.
[[nodiscard]] bool needsImport(const FilmParams& params);

/// The velocity sequence that vdblic_import makes of a film's input, in the folder OUTPUT.velocity.
class ImportedVelocity {
  public:
    /// Run vdblic_import, or go on with the complete sequence of the same file and options. An interrupted run leaves
    /// no folder.
    /// @throws as runTool(); OutputError if the folder cannot be made
    ImportedVelocity(const FilmParams& params, Reporter& reporter);

    [[nodiscard]] const std::string& pattern() const { return mPattern; }

    /// The import as a user would type it, with the sequence beside the output.
    [[nodiscard]] const std::string& command() const { return mCommand; }
    /// A command on the sequence, with the one beside the output in its place.
    [[nodiscard]] std::string asTyped(std::string command) const;

    void remove() const; ///< the sequence, and the folder if no other file is in it

  private:
    [[nodiscard]] bool isComplete(const std::string& key) const;

    std::filesystem::path mFolder, mKey;
    std::string mPattern, mBeside, mCommand; // patterns inside the folder and beside it
};

} // namespace vdblic
