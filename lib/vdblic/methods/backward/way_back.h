#pragma once

#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_voxel.h"
#include "vdblic/field/slabs.h"
#include "vdblic/field/vector.h"
#include "vdblic/field/velocity_field.h"
#include "vdblic/lic/leaf_velocities.h"
#include "vdblic/lic/pathline.h"
#include "vdblic/methods/flow_texture.h"

#include <cstddef>
#include <memory>

namespace vdblic {

/// The pathlines of a step backwards: from voxels of its second frame to their fluid's positions at the first.
///
/// The velocity is the step's with time and direction reversed, on the second frame's domain: a voxel that is new in it
/// has a velocity too. The midpoint rule is used where its error, about 2/3 |k2 − k1|² / |k1| (Hairer, Nørsett &
/// Wanner, Solving ODEs I, II.1, for a flow that turns), is below the tolerance, advancePaths() elsewhere. A path that
/// leaves the domain continues straight.
class WayBack {
  public:
    /// Prepare the velocity. @param params must outlive this, as must the step
    WayBack(const FlowStep& step, const PathlineParams& params);

    /// Beyond this, floats have no fractions; 64 steps back, positions must still fit into integers.
    static constexpr float kFarthest = 0x1p23f; // [voxels]

    /// Paths back from one leaf's voxels, row by row. One object serves one thread.
    class Leaf {
      public:
        /// @param velocities of the leaf, by velocitiesOf(); must outlive this
        Leaf(const WayBack& way, std::size_t leaf, const LeafVelocities& velocities, PathBatch& batch)
            : mWay(way), mBatch(batch), mOrigin(way.domain().origin(leaf)), mWindow(way.mField.window(mOrigin)),
              mVelocities(velocities)
        {
        }

        /// The centres of a row's voxels, the reversed velocity there, and their fluid's former positions [voxels],
        /// limited to kFarthest along each axis; NaN counts as so far.
        struct Row {
            Vector8 centre, slope, before;
        };
        /// @param lanes to follow; the results of others have no meaning
        [[nodiscard]] VDBLIC_INLINE Row row(int row, unsigned lanes) const
        {
            const LeafVoxel first = LeafVoxel::ofRow(row);
            const Vector8 centre = rowCentres(mOrigin[0] + first.x, mOrigin[1] + first.y, mOrigin[2]);
            const Vector8 slope = mVelocities.row(row);
            const Vector8 middle = mWay.mField.sample(mWindow, centre + slope * 0.5f, broadcast8(0.5f), slope, lanes);
            Row result{centre, slope, centre + middle};
            const Float8 turned2 = squaredLength(middle - slope), slope2 = squaredLength(slope);
            const float tolerance = 1.5f * mWay.mParams.tolerance;
            constexpr float kLongest2 = pathline::kMaxStride * pathline::kMaxStride;
            const Int8 isSmooth = (turned2 * turned2 <= slope2 * (tolerance * tolerance)) & (slope2 <= kLongest2);
            const unsigned rough = laneBits(~isSmooth) & lanes;
            if (__builtin_expect(rough != 0, 0)) follow(result, rough);
            return result;
        }

      private:
        /// The same with the adaptive integrator.
        [[gnu::noinline]] void follow(Row& row, unsigned lanes) const;

        const WayBack& mWay;
        PathBatch& mBatch;
        openvdb::Coord mOrigin;
        Bricks::Window mWindow;
        const LeafVelocities& mVelocities;
    };

    /// The reversed velocities at the second frame.
    [[nodiscard]] LeafVelocities velocitiesOf(std::size_t leaf) const
    {
        return {mField.start(), mField.frameDomain().refinement, domain().origin(leaf)};
    }

    /// The domain of the second frame's texture.
    [[nodiscard]] const Domain& domain() const { return mField.domain(); }

    /// Call work(leaf) for all own leaves of the second frame, in parallel, slab by slab. The velocity within the reach
    /// of paths from a slab is filled, and the first frame's leaves there were passed to open().
    /// @param open, close called with leaves of the first frame
    template<typename Open, typename Close, typename Work>
    void sweep(StageClock& clock, const Open& open, const Close& close, const Work& work)
    {
        mSlabs.sweep(
            mReach,
            [&](std::size_t slab) {
                const auto stage = clock.enter(&StageTimes::load);
                mField.fill(mVelocitySlabs[slab]);
                open(mFirstSlabs[slab]);
            },
            [&](std::size_t slab) {
                mField.release(mVelocitySlabs[slab]);
                close(mFirstSlabs[slab]);
            },
            [&](std::size_t slab) {
                const Slabs::Leaves leaves = mLastSlabs[slab];
                tbb::parallel_for(std::size_t(0), leaves.size(), [&](std::size_t i) {
                    if (domain().isOwn(leaves[i])) work(std::size_t(leaves[i]));
                });
            });
    }

  private:
    static VelocityField reversed(const FlowStep& step);

    const PathlineParams& mParams;
    VelocityField mField;
    // Slabs of the voxels of both frames; and in each, leaves of the first frame, of the second and of its velocity.
    Slabs mSlabs, mFirstSlabs, mLastSlabs, mVelocitySlabs;
    int mReach; // leaves
};

} // namespace vdblic
