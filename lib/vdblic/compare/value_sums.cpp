#include "vdblic/compare/value_sums.h"

#include "vdblic/field/vector.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace vdblic::compare {
namespace {

/// Sums and maxima run in eight lanes that are then joined pairwise: the same order on every machine.
constexpr std::size_t kLanes = 8;
template<typename T>
using Lanes = std::array<T, kLanes>;

double total(const Lanes<double>& x)
{
    return ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]));
}
double largest(const Lanes<double>& x)
{
    return *std::max_element(x.begin(), x.end());
}
std::uint64_t total(const Lanes<std::uint64_t>& x)
{
    return std::accumulate(x.begin(), x.end(), std::uint64_t(0));
}

/// Visit the values of a block: their number, their lane, and whether a mask has them.
template<typename Visit>
VDBLIC_INLINE void forEachValue(const BlockMask& mask, const Visit& visit)
{
    for (std::size_t first = 0; first < kBlockValues; first += kLanes) {
        const std::uint64_t row = mask[first / 64] >> (first % 64);
        for (std::size_t lane = 0; lane < kLanes; ++lane)
            visit(first + lane, lane, (row >> lane & 1) != 0);
    }
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
    Lanes<double> sum{}, squares{}, max{}, relative{}, peak{};
    Lanes<std::uint64_t> overFail{}, failing{};
    forEachValue(block.compared, [&](std::size_t n, std::size_t lane, bool isCompared) {
        const double error = isCompared ? block.error[n] : 0, magnitude = isCompared ? block.magnitude[n] : 0;
        const bool isOver = error > std::max(tolerances.relative * magnitude, tolerances.fail);
        const bool isOneSided = isOn(block.onlyA, n) || isOn(block.onlyB, n);
        sum[lane] += error;
        squares[lane] += error * error;
        max[lane] = std::max(max[lane], error);
        peak[lane] = std::max(peak[lane], magnitude);
        relative[lane] = std::max(relative[lane], error / (magnitude > 0 ? magnitude : 1));
        overFail[lane] += isOver ? 1 : 0;
        failing[lane] += isOver || (isCompared && isOneSided) ? 1 : 0;
    });
    sums.sum = total(sum);
    sums.squares = total(squares);
    sums.max = largest(max);
    sums.maxRelative = largest(relative);
    sums.peak = largest(peak);
    sums.overFail = total(overFail);
    sums.failing = total(failing);
}

VDBLIC_KERNEL void sumComponent(const ErrorBlock& block, std::size_t component, ValueSums& sums)
{
    Lanes<double> sum{}, squares{}, max{};
    forEachValue(block.compared, [&](std::size_t n, std::size_t lane, bool isCompared) {
        const double error = isCompared ? block.components[component][n] : 0;
        sum[lane] += error;
        squares[lane] += error * error;
        max[lane] = std::max(max[lane], error);
    });
    sums.componentSum[component] = total(sum);
    sums.componentSquares[component] = total(squares);
    sums.componentMax[component] = largest(max);
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
        sums.failing += sums.notFinite - count(both(bad, block.onlyA)) - count(both(bad, block.onlyB));
        sums.max = kInfinity;
    }
    return sums;
}

ValueSums sumEqualBlock(const ErrorBlock& block)
{
    ValueSums sums;
    sums.compared = count(block.compared);
    for (std::size_t n = 0; n < kBlockValues; ++n)
        sums.peak = isOn(block.compared, n) ? std::max(sums.peak, block.magnitude[n]) : sums.peak;
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
    return std::all_of(values.begin(), values.end(), // false for NaN too
                       [](double value) { return value <= std::numeric_limits<double>::max(); });
}

ValueDifference finish(const ValueSums& sums, int componentCount, double failPercent)
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
    result.onlyInA = sums.onlyInA;
    result.onlyInB = sums.onlyInB;
    result.failing = sums.failing;
    if (double(sums.failing) > failPercent / 100. * double(sums.compared)) result.verdict = Verdict::kDiffers;
    return result;
}

} // namespace vdblic::compare
