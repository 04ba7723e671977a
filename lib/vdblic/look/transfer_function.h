#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/look/transfer_params.h"

#include <glm/vec3.hpp>

#include <array>
#include <string>
#include <vector>

namespace vdblic {

/// Colour over one scalar and opacity over the same or another one, tabulated for the ray caster. Immutable; any number
/// of threads may read.
///
/// Opacity is stored as extinction: the optical depth of one voxel, −ln(1 − opacity). Optical depths add along a ray,
/// so a step of length s [voxels] has opacity 1 − exp(−extinction·s) = 1 − (1 − opacity)^s.
class TransferFunction {
  public:
    static constexpr int kEntries = 1024;
    /// Linear light, not premultiplied, and extinction per voxel.
    struct alignas(16) Entry {
        float red, green, blue, extinction;
    };

    /// Curves are constant before their first point and after their last one.
    /// @param params with opacity and range set; without an opacity range, both scalars have `range`
    /// @throws ParameterError
    explicit TransferFunction(const TransferParams& params);

    [[nodiscard]] const Entry* table() const { return mTable.data(); }
    /// The extinctions of all entries, contiguous.
    [[nodiscard]] const float* extinctions() const { return mExtinctions.data(); }
    [[nodiscard]] const TransferParams& params() const { return mParams; }
    /// `points` if the parameters hold colours of their own.
    [[nodiscard]] std::string colorMapName() const { return mParams.colors.empty() ? mParams.colorMap : "points"; }
    /// The corners of the colour curve, of the parameters or of the colour map.
    [[nodiscard]] std::vector<ColorPoint> colors() const
    {
        return mParams.colors.empty() ? colorMapPoints(mParams.colorMap) : mParams.colors;
    }
    [[nodiscard]] const std::vector<OpacityPoint>& opacity() const { return mParams.opacity; }
    [[nodiscard]] const std::array<double, 2>& range() const { return *mParams.range; }
    [[nodiscard]] const std::array<double, 2>& opacityRange() const
    {
        return mParams.opacityRange ? *mParams.opacityRange : range();
    }
    [[nodiscard]] ScalarAxis colorAxis() const { return {range(), mParams.colorScale}; }
    [[nodiscard]] ScalarAxis opacityAxis() const
    {
        const ValueScale unset = mParams.opacityRange ? ValueScale::kLinear : mParams.colorScale;
        return {opacityRange(), mParams.opacityScale.value_or(unset)};
    }

    /// Display (sRGB) values. @param position 0 to 1; clamped
    [[nodiscard]] glm::dvec3 displayColor(double position) const;
    /// Of one voxel. @param position 0 to 1; clamped
    [[nodiscard]] double opacityAt(double position) const;

    /// Table indices of eight values of the scalar that opacity follows, clamped to the table; any for NaN.
    [[nodiscard]] VDBLIC_INLINE Int8 entries(Float8 driver) const { return mOpacityScale.entries(driver); }
    /// The same for the scalar that colour follows.
    [[nodiscard]] VDBLIC_INLINE Int8 colorEntries(Float8 value) const { return mColorScale.entries(value); }

    /// Whether any value between two bounds of the scalar that opacity follows has an opacity above 0.
    [[nodiscard]] bool contributes(float low, float high) const;
    /// Whether all values between two bounds have an opacity above 0.
    [[nodiscard]] bool contributesThroughout(float low, float high) const;

  private:
    /// First and last entry that values between two bounds can have.
    [[nodiscard]] std::array<int, 2> entriesBetween(float low, float high) const;

    /// From values to entries of the table.
    ///
    /// On a logarithmic scale entries are even in the bits of the value, which rise with it: linearly between powers of
    /// two, so nearly as its logarithm. The table takes up the difference, so that no logarithm is needed.
    class Scale {
      public:
        explicit Scale(const ScalarAxis& axis);

        [[nodiscard]] VDBLIC_INLINE Int8 entries(Float8 value) const
        {
            const Float8 index = (mIsLog ? bitsAbove(value) : value - mLow) * mPerEntry;
            const Float8 last = broadcast8(float(kEntries - 1));
            const Float8 bounded = index < last ? index : last;
            return __builtin_convertvector(bounded > 0 ? bounded + 0.5f : Float8{}, Int8);
        }
        /// The position of an entry on the axis, 0 to 1.
        [[nodiscard]] double position(int entry) const;

      private:
        [[nodiscard]] VDBLIC_INLINE Float8 bitsAbove(Float8 value) const
        {
            const Float8 bounded = value > mLow ? value : broadcast8(mLow);
            return __builtin_convertvector(reinterpret_cast<Int8>(bounded) - mLowBits, Float8);
        }

        ScalarAxis mAxis;
        float mLow, mPerEntry;
        int mLowBits;
        bool mIsLog;
    };

    TransferParams mParams;
    Scale mOpacityScale, mColorScale;
    std::vector<Entry> mTable;
    std::vector<float> mExtinctions;
    std::vector<int> mVisibleBefore; // [i]: number of entries before i with an opacity above 0
};

} // namespace vdblic
