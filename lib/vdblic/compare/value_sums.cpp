#include "vdblic/compare/value_sums.h"

#include "vdblic/field/vector.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace vdblic::compare {
namespace {

VDBLIC_INLINE Double4 load(const double* p)
{
    Double4 x;
    __builtin_memcpy(&x, p, sizeof x);
    return x;
}

VDBLIC_INLINE Double4 broadcast(double x)
{
    return Double4{x, x, x, x};
}
VDBLIC_INLINE Double4 larger(Double4 a, Double4 b)
{
    return a > b ? a : b;
}

/// A mask of four lanes from bits 4·`half` to 4·`half` + 3 of a row.
VDBLIC_INLINE Long4 lanesOf(std::uint64_t row, std::size_t half)
{
    const auto bits = std::int64_t(row >> (4 * half));
    return (Long4{bits, bits, bits, bits} & Long4{1, 2, 4, 8}) != 0;
}

VDBLIC_INLINE Double4 keep(Double4 x, Long4 lanes)
{
    return lanes ? x : Double4{};
}

/// Sums and maxima run in eight lanes that are then joined pairwise: the same order on every machine.
VDBLIC_INLINE double total(const Double4 (&x)[2])
{
    const Double4 y = x[0] + x[1];
    return (y[0] + y[2]) + (y[1] + y[3]);
}
VDBLIC_INLINE double largest(const Double4 (&x)[2])
{
    const Double4 y = larger(x[0], x[1]);
    return std::max(std::max(y[0], y[2]), std::max(y[1], y[3]));
}
VDBLIC_INLINE std::uint64_t total(Long4 x)
{
    return std::uint64_t((x[0] + x[2]) + (x[1] + x[3]));
}

constexpr std::size_t kRows = kBlockValues / 8;
VDBLIC_INLINE std::uint64_t rowOf(const BlockMask& mask, std::size_t row)
{
    return mask[row / 8] >> (row % 8 * 8) & 255;
}

std::uint64_t count(const BlockMask& mask)
{
    std::uint64_t result = 0;
    for (const std::uint64_t word : mask)
        result += std::uint64_t(std::popcount(word));
    return result;
}

BlockMask both(const BlockMask& a, const BlockMask& b)
{
    BlockMask result;
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = a[i] & b[i];
    return result;
}

/// Everything but the values that are not finite.
VDBLIC_KERNEL void sumErrors(const ErrorBlock& block, const Tolerances& tolerances, ValueSums& sums)
{
    Double4 sum[2]{}, squares[2]{}, max[2]{}, relative[2]{}, peak[2]{};
    Long4 overFail{}, overWarn{}, failing{};
    for (std::size_t row = 0; row < kRows; ++row) {
        const std::uint64_t on = rowOf(block.compared, row);
        if (on == 0) continue;
        const std::uint64_t oneSided = rowOf(block.onlyA, row) | rowOf(block.onlyB, row);
        for (std::size_t half = 0; half < 2; ++half) {
            const Long4 lanes = lanesOf(on, half);
            const Double4 error = keep(load(&block.error[row * 8 + 4 * half]), lanes);
            const Double4 magnitude = keep(load(&block.magnitude[row * 8 + 4 * half]), lanes);
            sum[half] += error;
            squares[half] += error * error;
            max[half] = larger(error, max[half]);
            peak[half] = larger(magnitude, peak[half]);
            relative[half] = larger(error / (magnitude > 0. ? magnitude : broadcast(1.)), relative[half]);
            // A true lane is −1.
            const Long4 over = error > larger(broadcast(tolerances.relative) * magnitude, broadcast(tolerances.fail));
            overFail -= over;
            overWarn -= error > broadcast(tolerances.warn);
            failing -= over | lanesOf(oneSided, half);
        }
    }
    sums.sum = total(sum);
    sums.squares = total(squares);
    sums.max = largest(max);
    sums.maxRelative = largest(relative);
    sums.peak = largest(peak);
    sums.overFail = total(overFail);
    sums.overWarn = total(overWarn);
    sums.failing = total(failing);
}

VDBLIC_KERNEL void sumComponent(const ErrorBlock& block, std::size_t component, ValueSums& sums)
{
    Double4 sum[2]{}, squares[2]{}, max[2]{};
    for (std::size_t row = 0; row < kRows; ++row) {
        for (std::size_t half = 0; half < 2; ++half) {
            const Long4 lanes = lanesOf(rowOf(block.compared, row), half);
            const Double4 error = keep(load(&block.components[component][row * 8 + 4 * half]), lanes);
            sum[half] += error;
            squares[half] += error * error;
            max[half] = larger(error, max[half]);
        }
    }
    sums.componentSum[component] = total(sum);
    sums.componentSquares[component] = total(squares);
    sums.componentMax[component] = largest(max);
}

VDBLIC_KERNEL double largestMagnitude(const ErrorBlock& block)
{
    Double4 peak[2]{};
    for (std::size_t row = 0; row < kRows; ++row) {
        for (std::size_t half = 0; half < 2; ++half) {
            const Long4 lanes = lanesOf(rowOf(block.compared, row), half);
            peak[half] = larger(keep(load(&block.magnitude[row * 8 + 4 * half]), lanes), peak[half]);
        }
    }
    return largest(peak);
}

VDBLIC_KERNEL bool finite(const double* values)
{
    Long4 bad{};
    for (std::size_t i = 0; i < kBlockValues; i += 4) {
        // The comparison is false for NaN too.
        bad |= ~(load(values + i) <= broadcast(std::numeric_limits<double>::max()));
    }
    return (bad[0] | bad[1] | bad[2] | bad[3]) == 0;
}

} // namespace

void ValueSums::add(const ValueSums& other)
{
    if (other.first && (!first || *other.first < *first)) first = other.first;
    if (other.worst && (other.max > max || !worst || (other.max == max && *other.worst < *worst))) worst = other.worst;
    compared += other.compared;
    onlyInA += other.onlyInA;
    onlyInB += other.onlyInB;
    notFinite += other.notFinite;
    overFail += other.overFail;
    overWarn += other.overWarn;
    failing += other.failing;
    sum += other.sum;
    squares += other.squares;
    max = std::max(max, other.max);
    maxRelative = std::max(maxRelative, other.maxRelative);
    peak = std::max(peak, other.peak);
    for (std::size_t i = 0; i < 3; ++i) {
        componentSum[i] += other.componentSum[i];
        componentSquares[i] += other.componentSquares[i];
        componentMax[i] = std::max(componentMax[i], other.componentMax[i]);
    }
}

ValueSums sumBlock(const ErrorBlock& block, const Tolerances& tolerances)
{
    ValueSums sums;
    sumErrors(block, tolerances, sums);
    for (int i = 0; i < block.componentCount; ++i)
        sumComponent(block, std::size_t(i), sums);
    sums.compared = count(block.compared);
    sums.onlyInA = count(both(block.compared, block.onlyA));
    sums.onlyInB = count(both(block.compared, block.onlyB));
    const BlockMask bad = both(block.compared, block.notFinite);
    sums.notFinite = count(bad);
    if (sums.notFinite > 0) {
        sums.overFail += sums.notFinite;
        if (tolerances.warn < kInfinity) sums.overWarn += sums.notFinite;
        sums.failing += sums.notFinite - count(both(bad, block.onlyA)) - count(both(bad, block.onlyB));
        sums.max = kInfinity;
    }
    return sums;
}

ValueSums sumEqualBlock(const ErrorBlock& block)
{
    ValueSums sums;
    sums.compared = count(block.compared);
    sums.peak = largestMagnitude(block);
    return sums;
}

std::size_t firstFailing(const ErrorBlock& block, const Tolerances& tolerances)
{
    for (std::size_t n = 0; n < kBlockValues; ++n) {
        if (!isOn(block.compared, n)) continue;
        if (isOn(block.onlyA, n) || isOn(block.onlyB, n) || isOn(block.notFinite, n)) return n;
        if (block.error[n] > std::max(tolerances.fail, tolerances.relative * block.magnitude[n])) return n;
    }
    return kBlockValues;
}

std::size_t firstOfError(const ErrorBlock& block, double max)
{
    for (std::size_t n = 0; n < kBlockValues; ++n) {
        if (!isOn(block.compared, n)) continue;
        if (max == kInfinity ? isOn(block.notFinite, n) : block.error[n] == max) return n;
    }
    return kBlockValues;
}

bool allFinite(const std::array<double, kBlockValues>& values)
{
    return finite(values.data());
}

ValueDifference finish(const ValueSums& sums, int componentCount, double failPercent, std::optional<double> hardFail)
{
    const auto figures = [pairs = double(sums.compared - sums.notFinite)](double sum, double squares, double max) {
        if (pairs == 0) return ErrorFigures{max, 0, 0};
        return ErrorFigures{max, sum / pairs, std::sqrt(squares / pairs)};
    };
    ValueDifference result;
    result.compared = sums.compared;
    result.error = figures(sums.sum, sums.squares, sums.max);
    for (std::size_t i = 0; i < std::size_t(componentCount); ++i) {
        result.components.push_back(figures(sums.componentSum[i], sums.componentSquares[i], sums.componentMax[i]));
    }
    result.maxRelative = sums.maxRelative;
    result.peak = sums.peak;
    result.psnr = result.error.rms > 0 ? 20. * std::log10(result.peak / result.error.rms) : kInfinity;
    result.notFinite = sums.notFinite;
    result.overFail = sums.overFail;
    result.overWarn = sums.overWarn;
    result.onlyInA = sums.onlyInA;
    result.onlyInB = sums.onlyInB;
    result.failing = sums.failing;
    if (double(sums.failing) > failPercent / 100. * double(sums.compared) || (hardFail && sums.max > *hardFail)) {
        result.verdict = Verdict::kDiffers;
    } else if (sums.overWarn > 0) {
        result.verdict = Verdict::kWarns;
    }
    return result;
}

} // namespace vdblic::compare
