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
/// Floats of a state between two steps as grids of a checkpoint, in parts, so that no second copy of the whole state is
/// in memory. A round trip preserves every bit.

/// In how many parts the state on a domain's own leaves is saved: up to eight, the more the larger it is.
[[nodiscard]] std::size_t statePartCount(const Domain& domain);
/// The own leaves of one part.
[[nodiscard]] Domain::Leaves statePart(const Domain& domain, std::size_t part);
/// The bounding box of leaves.
[[nodiscard]] openvdb::CoordBBox boxOf(const Domain& domain, Domain::Leaves leaves);

/// A copy of the values on the given leaves, as a grid. Made in parallel.
[[nodiscard]] openvdb::FloatGrid::Ptr stateGrid(const Domain& domain, Domain::Leaves leaves,
                                                const LeafValues<float>& values, const std::string& name);
/// The same of integers, whose magnitudes are below 2²⁴.
[[nodiscard]] openvdb::FloatGrid::Ptr stateGrid(const Domain& domain, Domain::Leaves leaves,
                                                const LeafValues<std::int32_t>& values, const std::string& name);

/// Reads such grids from the files that they were saved in, one after the other. Not thread-safe.
class StateGridReader {
  public:
    /// @param domain must outlive this  @param names of the grids that every file has
    StateGridReader(const Domain& domain, const std::vector<std::string>& names);

    /// Call read(leaf, values) for each own leaf that a file's grid has, in parallel.
    /// @throws InputError, without the file's name, if the grid is missing or does not fit the domain
    void read(const VdbFile& file, const std::string& name,
              const std::function<void(std::size_t leaf, const float* values)>& read);

    /// @throws InputError if own leaves were in no file
    void finish() const;

  private:
    const Domain& mDomain;
    std::map<std::string, std::vector<std::uint8_t>> mFound; // of each grid, by leaf
};

} // namespace vdblic
