#pragma once

#include "vdblic/render/lanes.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

namespace vdblic {

/// What shading needs to know about eight samples, one a lane.
///
/// A further number is one more member here, set where samples are queued: the queue treats all members alike.
struct alignas(32) ShadeSamples {
    Float8 fraction[3]; ///< position in the cell, 0 to 1
    Unsigned8 record;   ///< index of the record at the cell's lowest corner
    Int8 task;          ///< index of the ray
    Float8 distance;    ///< along the ray [steps]
    Float8 weight;      ///< in the pixel
    Float8 stretched;   ///< the texture, see TextureModulation
    Int8 entry;         ///< index in the transfer function's table
};

/// Visible samples of any rays that wait to be shaded, first in, first out.
///
/// They wait until there are many, so that the branch on that is mostly predicted. Column k of the queue holds what the
/// k-th vector of ShadeSamples holds of eight samples.
class ShadeQueue {
  public:
    [[nodiscard]] bool empty() const { return mBegin == mEnd; }
    [[nodiscard]] bool isFull() const { return mEnd >= kMany; }
    [[nodiscard]] bool hasEight() const { return mBegin + kLanes <= mEnd; }

    /// Append the samples of the lanes whose bits are set.
    VDBLIC_INLINE void push(const ShadeSamples& samples, unsigned lanes)
    {
        const int end = mEnd; // a copy, which the stores cannot alias
        pushColumns(samples, kPacking[lanes], end, std::make_index_sequence<kColumns>());
        mEnd = end + __builtin_popcount(lanes);
    }

    /// The first eight samples. @pre hasEight()
    [[nodiscard]] VDBLIC_INLINE ShadeSamples front() const { return loadColumns(std::make_index_sequence<kColumns>()); }
    /// Remove the first eight samples. @pre hasEight()
    VDBLIC_INLINE void pop() { mBegin += kLanes; }

    /// Move what is left, less than eight samples, to the front.
    VDBLIC_INLINE void compact()
    {
        for (auto& column : mColumns)
            std::memmove(column, column + mBegin, sizeof(Int8));
        mEnd -= mBegin;
        mBegin = 0;
    }

    /// Append samples of weight 0 until there are eight.
    void fillUp()
    {
        for (; mEnd < mBegin + kLanes; ++mEnd) {
            for (auto& column : mColumns)
                column[mEnd] = 0;
        }
    }

  private:
    static constexpr std::size_t kColumns = sizeof(ShadeSamples) / sizeof(Int8);
    static constexpr int kMany = 128, kCapacity = kMany + 4 * kLanes;
    static_assert(kColumns * sizeof(Int8) == sizeof(ShadeSamples), "every member is made of vectors");

    // Written without loops, whose indices would force the samples out of registers.
    template<std::size_t... k>
    [[nodiscard]] VDBLIC_INLINE ShadeSamples loadColumns(std::index_sequence<k...>) const
    {
        ShadeSamples samples;
        (std::memcpy(reinterpret_cast<char*>(&samples) + k * sizeof(Int8), mColumns[k] + mBegin, sizeof(Int8)), ...);
        return samples;
    }
    template<std::size_t... k>
    VDBLIC_INLINE void pushColumns(const ShadeSamples& samples, Int8 order, int end, std::index_sequence<k...>)
    {
        (pushColumn(reinterpret_cast<const char*>(&samples) + k * sizeof(Int8), order, mColumns[k] + end), ...);
    }
    VDBLIC_INLINE static void pushColumn(const char* vector, Int8 order, std::int32_t* target)
    {
        Int8 values;
        std::memcpy(&values, vector, sizeof values);
        const Int8 packed = __builtin_shuffle(values, order);
        std::memcpy(target, &packed, sizeof packed);
    }

    std::int32_t mColumns[kColumns][kCapacity]; // bits of floats too
    int mBegin = 0, mEnd = 0;
};

} // namespace vdblic
