#pragma once

#include "vdblic/flow/reference_frame.h"
#include "vdblic/io/sequence.h"

#include <cstdint>
#include <filesystem>

namespace vdblic {

struct SequenceCoherenceParams;

/// Finds the texture file of a velocity's frame. Textures with substeps have numbers of their own, from the sequence's
/// first frame on. Immutable; any number of threads may read.
class TextureFiles {
  public:
    /// @throws ParameterError if one of velocity and texture is a file and the other a pattern; InputError naming the
    ///         file of a frame that one of them lacks
    explicit TextureFiles(const SequenceCoherenceParams& params);

    [[nodiscard]] std::filesystem::path path(std::int64_t frame) const;

    /// Whether inactive voxels of the first texture are empty.
    [[nodiscard]] bool areSparse() const { return mAreSparse; }

    /// VelocityParams::motion that the textures were made with.
    [[nodiscard]] double motion() const { return mMotion; }

    /// The observer that the textures were made for.
    [[nodiscard]] const ReferenceFrameParams& observer() const { return mObserver; }

  private:
    void readFirst();

    FramePattern mPattern;
    std::int64_t mSubsteps = 1, mFirst = 0; // textures to a frame; the frame whose texture has the same number
    double mMotion = 1;
    ReferenceFrameParams mObserver{};
    bool mAreSparse = false;
};

} // namespace vdblic
