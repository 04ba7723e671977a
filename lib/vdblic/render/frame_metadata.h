#pragma once

#include "vdblic/render/annotation_texts.h"

#include <openvdb/openvdb.h>

#include <string>
#include <vector>

namespace vdblic {

/// A text of a file's or a grid's metadata; empty if it has none.
[[nodiscard]] std::string textOf(const openvdb::MetaMap& metadata, const char* key);

/// The time of a file's frame.
[[nodiscard]] FrameClock clockOf(const openvdb::MetaMap& metadata);

/// The unit of a scalar: its metadata `unit`, or for speeds the file's unit of length per second.
[[nodiscard]] std::string unitOf(const openvdb::FloatGrid& scalar, const std::string& lengthUnit);

/// Names of the sources of streaks, the first for particles without one; empty if the file names none.
[[nodiscard]] std::vector<std::string> kindsOf(const openvdb::MetaMap& metadata);

} // namespace vdblic
