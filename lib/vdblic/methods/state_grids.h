#pragma once

#include "vdblic/field/domain.h"

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace vdblic {

struct VdbFile;

/// \file
/// A state's floats as checkpoint grids, in parts, so that no second copy of the whole state is in memory. A round trip
/// preserves every bit.

/// The number of parts of a state on a domain's own leaves: up to eight, growing with their number.
[[nodiscard]] std::size_t statePartCount(const Domain& domain);
/// The own leaves of one part.
[[nodiscard]] Domain::Leaves statePart(const Domain& domain, std::size_t part);
/// The bounding box of leaves.
[[nodiscard]] openvdb::CoordBBox boxOf(const Domain& domain, Domain::Leaves leaves);

/// A copy of the values on the given leaves, as a grid. Made in parallel.
[[nodiscard]] openvdb::FloatGrid::Ptr stateGrid(const Domain& domain, Domain::Leaves leaves,
                                                const LeafValues<float>& values, const std::string& name);
/// The same for integers of magnitude below 2²⁴.
[[nodiscard]] openvdb::FloatGrid::Ptr stateGrid(const Domain& domain, Domain::Leaves leaves,
                                                const LeafValues<std::int32_t>& values, const std::string& name);

/// Reads such grids from their files, one after the other. Not thread-safe.
class StateGridReader {
  public:
    /// @param domain must outlive this  @param names of the grids in every file
    StateGridReader(const Domain& domain, const std::vector<std::string>& names);

    /// Call read(leaf, values) for each own leaf in a file's grid, in parallel.
    /// @throws InputError, without the file's name, if the grid is missing or does not fit the domain
    void read(const VdbFile& file, const std::string& name,
              const std::function<void(std::size_t leaf, const float* values)>& read);

    /// @throws InputError if an own leaf was in no file
    void finish() const;

  private:
    const Domain& mDomain;
    std::map<std::string, std::vector<std::uint8_t>> mFound; // by grid and leaf
};

} // namespace vdblic
