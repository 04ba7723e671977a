#pragma once

#include "vdblic/cast/tubes.h"
#include "vdblic/io/sequence.h"
#include "vdblic/look/histogram.h"
#include "vdblic/render/annotation_texts.h"
#include "vdblic/volume/texture_volume.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdblic {

class LeafShare;
struct Moment;
struct PicturePlan;
struct VdbFile;
struct View;

/// A frame that was read.
struct LoadedTexture {
    FrameFile file;
    std::string name; ///< of the grid that is shown
    openvdb::FloatGrid::Ptr texture{}, color{},
        opacity{};                         ///< colour and opacity follow two grids or one; null for lines
    bool hasColor = true;                  ///< if not, the texture colours
    std::string opacityBy{};               ///< name of the scalar that opacity follows
    std::optional<TextureVolume> volume{}; ///< voxels, or
    std::optional<Tubes> tubes{};          ///< lines
    FrameClock clock{};                    ///< of the file's metadata
    std::string colorUnit{}, opacityUnit{}, lengthUnit{}; ///< of the scalars and of the world; empty: unknown
    std::vector<std::string> kinds{};                     ///< as TransferParams has them, where sources colour
    bool isSparse = false;                                ///< whether inactive voxels are empty
    std::shared_ptr<const LoadedTexture> lines{};         ///< drawn in the voxels; or null
    openvdb::FloatGrid::Ptr flowVoxels{}; ///< of a sparse texture or lines: a grid whose active voxels are the flow's

    double after = 0; ///< time of the lines after the file's [frames]

    [[nodiscard]] bool empty() const { return tubes ? tubes->empty() : volume->empty(); }
    [[nodiscard]] const PlacedBox& box() const { return tubes ? static_cast<const PlacedBox&>(*tubes) : *volume; }
    /// Voxels and parts of lines that are left out because a value is not a finite number.
    [[nodiscard]] std::size_t unusable() const
    {
        return (tubes ? tubes->unusable() : volume->unusableVoxels()) + (lines ? lines->unusable() : 0);
    }

    /// A grid whose active voxels are the flow's, fine enough for the faces of solids.
    /// @throws InputError naming the file if lines come without one
    [[nodiscard]] openvdb::FloatGrid::ConstPtr domain() const;

    /// Count the voxels, or places along the lines. @throws InputError naming the file
    void addTo(TextureHistograms& histograms) const;

    /// The number of the frame; between two frames a number between theirs.
    [[nodiscard]] double frame() const { return double(file.frame) + after; }

    [[nodiscard]] double bytes() const; ///< estimated memory
};

/// The file of the lines in a frame's voxels. @param plan with lines
[[nodiscard]] std::filesystem::path linesFile(const PicturePlan& plan, std::int64_t frame);

/// Check by the headers that the plan's lines, if any, can be drawn in a frame: it has voxels, and their file lines.
/// @throws InputError naming the file
void checkLines(const PicturePlan& plan, const FrameFile& frame);

/// Estimated memory of a voxel of a frame [bytes].
[[nodiscard]] double bytesPerVoxel(const PicturePlan& plan);

/// Read a frame. Thread-safe.
/// @param view  the frame's view, once it is chosen: gives the grid for opacity; leaves that its look hides are not
/// prepared
/// @param share the leaves to read of a frame that ranks share; null: all
/// @throws InputError naming the file
[[nodiscard]] LoadedTexture loadFrame(const PicturePlan& plan, const FrameFile& frame, const View* view = nullptr,
                                      const LeafShare* share = nullptr);
/// The same for a moment; `share` is for frames.
[[nodiscard]] LoadedTexture loadFrame(const PicturePlan& plan, const Moment& moment, const View* view = nullptr,
                                      const LeafShare* share = nullptr);
/// The same for a file in memory. @param frame number and name, for masks and messages
[[nodiscard]] LoadedTexture loadFrame(const PicturePlan& plan, const VdbFile& file, const FrameFile& frame,
                                      const View* view = nullptr, const LeafShare* share = nullptr);

} // namespace vdblic
