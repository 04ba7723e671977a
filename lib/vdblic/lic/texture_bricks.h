#pragma once

#include "vdblic/field/bricks.h"
#include "vdblic/field/slabs.h"

#include <cstddef>
#include <memory>
#include <utility>

namespace vdblic {

/// A texture and its sharpened form, to be sampled together between voxels. Any number of threads may sample, and none
/// while leaves are filled or released.
class TextureBricks {
  public:
    /// @param texture, sharp must outlive every fill()
    TextureBricks(std::shared_ptr<const Domain> domain, const LeafValues<float>& texture,
                  const LeafValues<float>& sharp)
        : mTexture(texture), mSharp(sharp)
    {
        mBricks.cover(std::move(domain));
    }

    /// Only leaves that were filled and not released can be sampled.
    void fill(Slabs::Leaves leaves)
    {
        mBricks.fill(leaves, [&](std::size_t leaf, BricksOf<4>::Record* records) {
            visitBrick(mBricks.domain(), leaf, [&](int record, int there, unsigned offset) {
                const auto at = std::size_t(there);
                records[record] = there < 0 ? BricksOf<4>::Record{}
                                            : BricksOf<4>::Record{{mTexture[at][offset], mSharp[at][offset], 1, 0}};
            });
        });
    }
    void release(Slabs::Leaves leaves) { mBricks.release(leaves); }

    /// Means over the corners in the domain, and the corners' share of the weights; without coverage the means have no
    /// meaning.
    struct Samples {
        Float8 texture, sharp, coverage;
    };
    /// Sample eight positions at once.
    /// @param window the leaf in and around which they are expected; elsewhere sampling is slower
    /// @param lanes  those to sample; the others' results have no meaning
    [[nodiscard]] VDBLIC_INLINE Samples at(const LeafWindow& window, const Vector8& position, unsigned lanes) const
    {
        Float4 rows[8];
        mBricks.interpolate(window, position, lanes, rows);
        Float8 columns[4];
        transpose(rows, columns);
        return {columns[0] / columns[2], columns[1] / columns[2], columns[2]};
    }

  private:
    const LeafValues<float>&mTexture, &mSharp;
    BricksOf<4> mBricks;
};

} // namespace vdblic
