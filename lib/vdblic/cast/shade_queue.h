#pragma once

#include "vdblic/cast/lanes.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

namespace vdblic {

/// The inputs of shading, one column of 32-bit values for each number of a sample.
///
/// To add a number, add a member and set it where samples are queued: the queue treats all members alike.
template<typename Of>
struct ShadeColumns {
    typename Of::Floats position[3]; ///< relative to the first voxel of its leaf
    typename Of::Unsigneds leaf;     ///< its number
    typename Of::Ints task;          ///< index of the ray
    typename Of::Floats distance;    ///< along the ray [steps]
    typename Of::Floats weight;      ///< in the pixel
    typename Of::Floats stretched;   ///< the texture, see TextureModulation
    typename Of::Ints entry;         ///< index in the transfer function's table, of the scalar that opacity follows
};

struct InLanes {
    using Floats = Float8;
    using Ints = Int8;
    using Unsigneds = Unsigned8;
};
/// Eight samples, one a lane.
using ShadeSamples = ShadeColumns<InLanes>;

/// Visible samples of any rays that wait to be shaded, first in, first out.
///
/// They wait until there are many, so that the branch on that is mostly predicted.
class ShadeQueue {
  public:
    static constexpr int kMany = 128, kCapacity = kMany + 4 * kLanes;

    struct InMemory {
        using Floats = float[kCapacity];
        using Ints = std::int32_t[kCapacity];
        using Unsigneds = std::uint32_t[kCapacity];
    };

    [[nodiscard]] bool empty() const { return mBegin == mEnd; }
    [[nodiscard]] bool isFull() const { return mEnd >= kMany; }
    [[nodiscard]] bool hasEight() const { return mBegin + kLanes <= mEnd; }

    /// The samples of the queue; the first one at index begin().
    [[nodiscard]] const ShadeColumns<InMemory>& columns() const { return mColumns; }
    [[nodiscard]] int begin() const { return mBegin; }

    /// Append the samples of the lanes whose bits are set.
    VDBLIC_INLINE void push(const ShadeSamples& samples, unsigned lanes)
    {
        const int end = mEnd; // a copy, which the stores cannot alias
        storeColumns(samples, kPacking[lanes], end, std::make_index_sequence<kColumns>());
        mEnd = end + __builtin_popcount(lanes);
    }

    /// Remove the first eight samples. @pre hasEight()
    VDBLIC_INLINE void pop() { mBegin += kLanes; }

    /// Move the rest, fewer than eight samples, to the front.
    VDBLIC_INLINE void compact()
    {
        for (std::size_t k = 0; k < kColumns; ++k)
            std::memmove(column(k), column(k) + mBegin * kBytes, sizeof(Int8));
        mEnd -= mBegin;
        mBegin = 0;
    }

    /// Append samples of weight 0 until there are eight, unless there are.
    void fillUp()
    {
        if (hasEight()) return;
        for (std::size_t k = 0; k < kColumns; ++k)
            std::memset(column(k) + mEnd * kBytes, 0, sizeof(Int8));
        mEnd = mBegin + kLanes;
    }

  private:
    static constexpr std::size_t kColumns = sizeof(ShadeSamples) / sizeof(Int8), kBytes = sizeof(std::int32_t);

    /// The bytes of a member of ShadeColumns.
    VDBLIC_INLINE char* column(std::size_t k) { return reinterpret_cast<char*>(&mColumns) + k * kCapacity * kBytes; }

    // Without a loop, whose index would force the samples out of registers.
    template<std::size_t... k>
    VDBLIC_INLINE void storeColumns(const ShadeSamples& samples, Int8 order, int end, std::index_sequence<k...>)
    {
        const auto* vectors = reinterpret_cast<const char*>(&samples);
        (storeColumn(vectors + k * sizeof(Int8), order, column(k) + end * kBytes), ...);
    }
    VDBLIC_INLINE static void storeColumn(const char* vector, Int8 order, char* target)
    {
        Int8 values;
        std::memcpy(&values, vector, sizeof values);
        const Int8 packed = permuted(values, order);
        std::memcpy(target, &packed, sizeof packed);
    }

    ShadeColumns<InMemory> mColumns;
    static_assert(sizeof mColumns == kColumns * kCapacity * kBytes);
    int mBegin = 0, mEnd = 0;
};

} // namespace vdblic
