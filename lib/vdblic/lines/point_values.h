#pragma once

#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/points/PointDataGrid.h>
#include <openvdb/tools/PointIndexGrid.h>

#include <string>
#include <vector>

namespace vdblic {

/// Append an attribute to a grid of points.
/// @param index  from which the grid was made  @param values one per point, in the order of the index's points
template<typename T, typename Codec = openvdb::points::NullCodec>
void appendValues(openvdb::points::PointDataGrid& grid, const openvdb::tools::PointIndexGrid& index,
                  const std::string& name, const std::vector<T>& values)
{
    using Values = openvdb::points::PointAttributeVector<T>;
    openvdb::points::appendAttribute<T, Codec>(grid.tree(), name);
    openvdb::points::populateAttribute<openvdb::points::PointDataTree, openvdb::tools::PointIndexTree, Values>(
        grid.tree(), index.tree(), name, Values(values));
}

} // namespace vdblic
