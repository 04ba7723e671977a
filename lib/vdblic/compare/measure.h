#pragma once

#include "vdblic/compare/compare.h"
#include "vdblic/compare/value_metric.h"
#include "vdblic/compare/value_sums.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace vdblic::compare {

/// The largest finite magnitude of two values; 0 if neither is finite.
template<typename T>
double finiteMagnitude(const T& a, const T& b)
{
    double result = 0;
    for (const double magnitude : {Metric<T>::magnitude(a), Metric<T>::magnitude(b)}) {
        if (magnitude <= std::numeric_limits<double>::max()) result = std::max(result, magnitude);
    }
    return result;
}

/// |a − b|; infinite if the values differ and one is not finite.
template<typename T>
double errorBetween(const T& a, const T& b)
{
    if (Metric<T>::same(a, b)) return 0;
    const double error = Metric<T>::error(a, b);
    return error <= std::numeric_limits<double>::max() ? error : std::numeric_limits<double>::infinity();
}

/// Set the errors, magnitudes and `notFinite` of a block; its other masks stay.
template<typename T>
void measureBlock(const T* a, const T* b, ErrorBlock& block)
{
    using M = Metric<T>;
    block.componentCount = M::kComponents;
    block.notFinite = {};
    for (std::size_t n = 0; n < kBlockValues; ++n) {
        block.error[n] = M::error(a[n], b[n]);
        block.magnitude[n] = std::max(M::magnitude(a[n]), M::magnitude(b[n]));
    }
    if constexpr (M::kComponents > 0) {
        for (int i = 0; i < M::kComponents; ++i) {
            auto& errors = block.components[std::size_t(i)];
            for (std::size_t n = 0; n < kBlockValues; ++n)
                errors[n] = M::componentError(a[n], b[n], i);
        }
    }
    if (allFinite(block.error)) return;
    for (std::size_t n = 0; n < kBlockValues; ++n) {
        if (block.error[n] <= std::numeric_limits<double>::max()) continue;
        if (!M::same(a[n], b[n])) setOn(block.notFinite, n);
        block.error[n] = 0;
        block.magnitude[n] = finiteMagnitude(a[n], b[n]);
        for (auto& errors : block.components)
            errors[n] = 0;
    }
}

/// Sum over items 0 … count − 1 in parallel. The order of additions does not depend on the number of threads.
/// @param makeMeter makes a callable (item, sums) with buffers of its own; called by several threads
template<typename MakeMeter>
ValueSums sumInOrder(std::size_t count, const MakeMeter& makeMeter)
{
    constexpr std::size_t kTaskItems = 16, kBatchTasks = 256, kBatch = kTaskItems * kBatchTasks;
    ValueSums sums;
    std::vector<ValueSums> parts(kBatchTasks);
    for (std::size_t begin = 0; begin < count; begin += kBatch) {
        const std::size_t end = std::min(begin + kBatch, count);
        const std::size_t tasks = (end - begin + kTaskItems - 1) / kTaskItems;
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tasks), [&](const auto& range) {
            const auto meter = makeMeter();
            for (std::size_t task = range.begin(); task < range.end(); ++task) {
                parts[task] = {};
                const std::size_t first = begin + task * kTaskItems;
                for (std::size_t i = first; i < std::min(first + kTaskItems, end); ++i)
                    (*meter)(i, parts[task]);
            }
        });
        for (std::size_t task = 0; task < tasks; ++task)
            sums.add(parts[task]);
    }
    return sums;
}

} // namespace vdblic::compare
