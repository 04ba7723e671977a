#pragma once

#include "vdblic/io/sequence.h"
#include "vdblic/render/annotation_texts.h"
#include "vdblic/volume/texture_volume.h"

#include <openvdb/openvdb.h>

#include <string>
#include <vector>

namespace vdblic {

class LeafShare;
struct PicturePlan;
struct VdbFile;
struct View;

/// A frame that was read.
struct LoadedTexture {
    FrameFile file;
    openvdb::FloatGrid::Ptr texture, color, opacity; ///< colour and opacity follow two grids or one
    bool hasColor;                                   ///< if not, the texture colours
    std::string opacityBy;                           ///< name of the grid that opacity follows
    TextureVolume volume;
    FrameClock clock;                                 ///< of the file's metadata
    std::string colorUnit, opacityUnit, lengthUnit{}; ///< of the scalars and of the world; empty: unknown
    std::vector<std::string> kinds{};                 ///< as TransferParams has them, where sources colour
    bool isSparse = false;                            ///< whether inactive voxels are empty
    openvdb::FloatGrid::Ptr flowVoxels{}; ///< of a sparse texture: a grid whose active voxels are the flow's

    /// A grid whose active voxels are the flow's, fine enough for the faces of solids.
    [[nodiscard]] openvdb::FloatGrid::ConstPtr domain() const;

    /// One of the scalars on the texture's voxels. @throws InputError naming the file
    [[nodiscard]] openvdb::FloatGrid::ConstPtr onTexture(const openvdb::FloatGrid::Ptr& scalar) const;

    [[nodiscard]] double bytes() const; ///< estimate of the memory that it takes
};

/// Estimate of the memory that a voxel of a frame takes.
[[nodiscard]] double bytesPerVoxel(const PicturePlan& plan);

/// Read a frame. Thread-safe.
/// @param view that the frame is to be shown in, once it is chosen: opacity follows its grid, and leaves that its look
///              hides are not prepared
/// @param share the leaves that are read, of a frame that ranks share; null: all
/// @throws InputError naming the file
[[nodiscard]] LoadedTexture loadFrame(const PicturePlan& plan, const FrameFile& frame, const View* view = nullptr,
                                      const LeafShare* share = nullptr);
/// The same for what a file holds. @param frame number and name, for masks and messages
[[nodiscard]] LoadedTexture loadFrame(const PicturePlan& plan, const VdbFile& file, const FrameFile& frame,
                                      const View* view = nullptr, const LeafShare* share = nullptr);

} // namespace vdblic
