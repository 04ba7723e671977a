#pragma once

#include "vdblic/field/vector.h"
#include "vdblic/render/color_map.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic {

/// A corner of a piecewise linear opacity curve.
struct OpacityPoint {
    double position; ///< 0 to 1 over the range of magnitudes
    double opacity;  ///< of one voxel, 0 to 1
};

/// Parse `0:0,0.4:0.05,1:0.8` into points of position and opacity. @throws ParameterError
[[nodiscard]] std::vector<OpacityPoint> parseOpacity(std::string_view text);
/// The text parseOpacity() reads back.
[[nodiscard]] std::string opacityText(const std::vector<OpacityPoint>& points);

/// How magnitude becomes colour and opacity.
struct TransferParams {
    std::string colorMap = "turbo";
    std::vector<ColorPoint> colors{}; ///< by rising position, in place of the colour map
    /// Opacity of one voxel of full texture, by rising position; empty: chosen from the frames.
    std::vector<OpacityPoint> opacity{};
    /// Magnitudes at positions 0 and 1 [world/s]; unset: percentiles of the frames.
    std::optional<std::array<double, 2>> range{};

    /// @throws ParameterError
    void validate() const;
};

/// Colour and opacity by magnitude, tabulated for the ray caster. Immutable.
///
/// Opacity is kept as extinction, the optical depth of one voxel, −ln(1 − opacity): optical depths add along a
/// ray, so a step of any length s has opacity 1 − exp(−extinction·s), the usual correction 1 − (1 − opacity)^s.
class TransferFunction {
  public:
    static constexpr int kEntries = 1024;
    /// Linear light, not premultiplied, and extinction per voxel.
    struct alignas(16) Entry {
        float red, green, blue, extinction;
    };

    /// @param params with opacity and range chosen; curves are constant before their first point and after their last
    /// @throws ParameterError
    explicit TransferFunction(const TransferParams& params);

    [[nodiscard]] const Entry* table() const { return mTable.data(); }
    /// The entries' extinctions alone, side by side.
    [[nodiscard]] const float* extinctions() const { return mExtinctions.data(); }
    /// What it was made from.
    [[nodiscard]] const TransferParams& params() const { return mParams; }
    /// `points` if points were given.
    [[nodiscard]] std::string colorMapName() const { return mParams.colors.empty() ? mParams.colorMap : "points"; }
    [[nodiscard]] const std::vector<OpacityPoint>& opacity() const { return mParams.opacity; }
    [[nodiscard]] const std::array<double, 2>& range() const { return *mParams.range; }

    /// As displayed (sRGB). @param position 0 to 1; clamped
    [[nodiscard]] glm::dvec3 displayColor(double position) const;

    /// The entries of eight magnitudes; below and above the range the first and the last.
    [[nodiscard]] VDBLIC_INLINE Int8 entries(Float8 magnitude) const
    {
        const Float8 place = (magnitude - mLow) * mScale;
        const Float8 last = broadcast8(float(kEntries - 1));
        const Float8 below = place < last ? place : last; // false for NaN, too
        return __builtin_convertvector(below > 0 ? below + 0.5f : Float8{}, Int8);
    }

    /// Whether any magnitude between these two has an opacity.
    [[nodiscard]] bool contributes(float low, float high) const;

  private:
    TransferParams mParams;
    float mLow, mScale;
    std::vector<Entry> mTable;
    std::vector<float> mExtinctions;
    std::vector<int> mOpaqueBefore; // entries with an opacity before each entry
};

} // namespace vdblic
