#pragma once

#include "vdblic/coherence/coherence_figures.h"
#include "vdblic/coherence/coherence_params.h"
#include "vdblic/coherence/estimate.h"
#include "vdblic/coherence/sparse_figures.h"
#include "vdblic/core/reporter.h"

#include <array>
#include <cstddef>
#include <vector>

namespace vdblic {

/// Means over frames of the figures of one texture, raw or smoothed.
struct MeanFigures {
    std::array<Estimate, kNamedFigures.size()> figures; ///< in the order of kNamedFigures
    std::vector<double> along, across;
};

/// Means over frames of the figures of one class of displacement.
struct MeanCleanness {
    std::size_t points = 0;                                 ///< of all frames
    std::array<Estimate, kCleannessFigures.size()> figures; ///< in the order of kCleannessFigures
};

/// Sparse textures set only `refine` and `sparse`; dense ones set all but `sparse`.
struct SequenceCoherence {
    std::array<int, 3> refine{1, 1, 1}; ///< texture voxels in a voxel of the velocity, along each axis
    std::vector<double> lags;           ///< of every autocorrelation: coherenceLags()
    std::vector<FrameCoherence> frames;
    MeanFigures raw, smoothed;
    std::array<MeanCleanness, kDisplacementClasses.size()> byDisplacement;
    std::vector<SparseCoherence> sparse;
    std::array<Estimate, kSparseFigures.size()> sparseMeans{}; ///< in the order of kSparseFigures
};

/// Measure every frame of a texture sequence, and report each one as soon as its figures are known.
///
/// The successor of a frame is the next one selected; the last frame has no successor and no temporal figures. The
/// texture may be finer than the velocity; their transforms show the refinement. Textures at
/// substeps between the velocity's frames are skipped. Sparse textures have figures of their own.
/// @throws ParameterError; InputError if the velocity or the texture of a frame is missing, if the texture's transform
///         is not a refinement of the velocity's, the same in every frame; if
///         some textures are sparse and others not;
///         OutputError
SequenceCoherence coherenceOfSequence(const SequenceCoherenceParams& params, Reporter& reporter);

} // namespace vdblic
