#include "vdblic/lic/neighbourhood.h"

namespace vdblic {

Neighbourhood gatherNeighbourhood(const Domain& domain, const LeafValues<float>& values, const openvdb::Coord& origin)
{
    // Along each axis: the last plane of the leaf before, the leaf itself, the first plane of the leaf after.
    constexpr int kLeafDim = Domain::Leaf::DIM;
    constexpr std::array<std::array<int, 2>, 3> kRange = {{{-1, 0}, {0, kLeafDim}, {kLeafDim, kLeafDim + 1}}};
    Neighbourhood result;
    for (int part = 0; part < 27; ++part) {
        const auto &rx = kRange[std::size_t(part / 9)], &ry = kRange[std::size_t(part / 3 % 3)],
                   &rz = kRange[std::size_t(part % 3)];
        const int leaf = domain.findLeaf(Int4{origin[0] + rx[0], origin[1] + ry[0], origin[2] + rz[0], 0});
        for (int x = rx[0]; x < rx[1]; ++x) {
            for (int y = ry[0]; y < ry[1]; ++y) {
                for (int z = rz[0]; z < rz[1]; ++z) {
                    const unsigned offset = Domain::offset(Int4{x, y, z, 0});
                    const bool valid = leaf >= 0 && domain.isActive(leaf, offset);
                    const std::size_t to = Neighbourhood::index(x, y, z);
                    result.valid[to] = valid ? 1 : 0;
                    result.value[to] = valid ? values[std::size_t(leaf)][offset] : 0;
                }
            }
        }
    }
    return result;
}

void sumNeighbours(Neighbourhood::Numbers& numbers, float centre)
{
    constexpr int kDim = Neighbourhood::kDim;
    for (const int stride : {1, kDim, kDim * kDim}) {
        const auto source = numbers;
        const int last = int(source.size()) - stride;
        for (int i = stride; i < last; ++i) {
            numbers[std::size_t(i)] =
                source[std::size_t(i - stride)] + centre * source[std::size_t(i)] + source[std::size_t(i + stride)];
        }
    }
}

} // namespace vdblic
