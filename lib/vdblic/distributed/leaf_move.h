#pragma once

#include "vdblic/core/exchange.h"
#include "vdblic/distributed/message.h"
#include "vdblic/distributed/partition.h"
#include "vdblic/field/domain.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdblic {

/// Values on own leaves, handed over to the ranks that own the leaves in another partition. Collective.
/// @param from, to the same domain with this rank's own leaves before and in that partition
template<typename T>
[[nodiscard]] LeafValues<T> moved(Exchange& exchange, const Partition& partition, const Domain& from, const Domain& to,
                                  const LeafValues<T>& values)
{
    LeafValues<T> result(to, T(0), to.own());
    std::vector<Exchange::Bytes> messages(std::size_t(exchange.size()));
    for (const std::uint32_t leaf : from.own()) {
        if (to.isOwn(leaf)) {
            std::copy_n(values[leaf], LeafVoxel::kCount, result[leaf]);
            continue;
        }
        Exchange::Bytes& message = messages[std::size_t(partition.ownerOfTexture(to.origin(leaf)))];
        put(message, leaf);
        put(message, values[leaf], LeafVoxel::kCount);
    }
    for (const Exchange::Bytes& bytes : exchange.swap(std::move(messages))) {
        for (MessageReader message(bytes); !message.atEnd();) {
            const auto leaf = message.get<std::uint32_t>();
            message.get(result[leaf], LeafVoxel::kCount);
        }
    }
    return result;
}

} // namespace vdblic
