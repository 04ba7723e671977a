#pragma once

#include "vdblic/core/message.h"
#include "vdblic/field/domain.h"
#include "vdblic/field/leaf_owners.h"
#include "vdblic/field/leaf_voxel.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace vdblic {

/// Hand values on own leaves over to the owners of the leaves in another partition. Collective.
/// @param from, to the same domain in the old and the new partition
template<typename T>
[[nodiscard]] LeafValues<T> handedOver(const LeafOwners& owners, const Domain& from, const Domain& to,
                                       const LeafValues<T>& values)
{
    LeafValues<T> result(to, T(0), to.own());
    for (const std::uint32_t leaf : from.own()) {
        if (to.isOwn(leaf)) std::copy_n(values[leaf], LeafVoxel::kCount, result[leaf]);
    }
    owners.send(
        to,
        [&](std::size_t leaf, Exchange::Bytes& message) {
            if (from.isOwn(leaf)) put(message, values[leaf], LeafVoxel::kCount);
        },
        [&](std::size_t leaf, MessageReader& message) { message.get(result[leaf], LeafVoxel::kCount); });
    return result;
}

} // namespace vdblic
