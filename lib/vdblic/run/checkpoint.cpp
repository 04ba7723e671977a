#include "vdblic/run/checkpoint.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/version.h"
#include "vdblic/io/checkpoint_mark.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <sstream>
#include <system_error>

namespace vdblic {
namespace {

using Keys = CheckpointKeys;

std::string inputKey(std::size_t index)
{
    return fmt::format("input {:06}", index);
}

std::string partKey(std::size_t index)
{
    return fmt::format("part {:06}", index);
}

std::string textMetadata(const openvdb::MetaMap& metadata, const std::string& key)
{
    const auto text = metadata.getMetadata<openvdb::StringMetadata>(key);
    return text ? text->value() : "";
}

constexpr const char* kMend = "delete the checkpoint to start from the beginning";

/// A parameter and its value, for messages.
std::string shown(const std::string& key, const std::string& value)
{
    return value.empty() ? fmt::format("no `{}`", key) : fmt::format("`{}` {}", key, value);
}

/// Reads the numbers in a checkpoint's metadata.
class PositionReader {
  public:
    PositionReader(const std::filesystem::path& path, const openvdb::MetaMap& metadata)
        : mPath(path), mMetadata(metadata)
    {
    }

    template<typename T>
    [[nodiscard]] T get(const char* key) const
    {
        const auto value = mMetadata.getMetadata<openvdb::TypedMetadata<T>>(key);
        if (!value) refuseCheckpoint(mPath, fmt::format("is no checkpoint of vdblic_advect: it has no '{}'", key));
        return value->value();
    }

  private:
    const std::filesystem::path& mPath;
    const openvdb::MetaMap& mMetadata;
};

/// Refuse numbers that no run writes.
void checkPosition(const std::filesystem::path& path, const RunPosition& position)
{
    constexpr double kLeast = 1e-18, kMost = 1e18;
    const auto isPositive = [](double number) { return number >= kLeast && number <= kMost; };
    if (std::int64_t(position.steps) >= 0 && position.frameSpacing >= 0 && std::abs(position.time) <= kMost &&
        isPositive(position.interval) && isPositive(position.motion))
        return;
    refuseCheckpoint(path, fmt::format("tells of a place where no run is: {} steps, {} s between frames, time {} s, "
                                       "frame numbers {} apart, motion {}: copy it again",
                                       std::int64_t(position.steps), position.interval, position.time,
                                       position.frameSpacing, position.motion));
}

/// @param text the box's corners, and the name of a file beside the checkpoint
CheckpointPart partOf(const std::filesystem::path& checkpoint, const std::string& text)
{
    std::istringstream words(text);
    openvdb::Coord low, high;
    std::string name;
    words >> low[0] >> low[1] >> low[2] >> high[0] >> high[1] >> high[2] >> std::ws;
    std::getline(words, name);
    if (!words || name.empty() || std::filesystem::path(name).has_parent_path())
        refuseCheckpoint(checkpoint, "lists its parts wrongly: copy it again");
    return {checkpoint.parent_path() / name, {low, high}};
}

} // namespace

void writeCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint, const ParameterTexts& parameters)
{
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored) && !isCheckpoint(path))
        throw OutputError(fmt::format("{}: is no checkpoint, and one would replace it; move it away", path.string()));
    openvdb::MetaMap metadata;
    metadata.insertMeta(Keys::kSteps, openvdb::Int64Metadata(std::int64_t(checkpoint.position.steps)));
    metadata.insertMeta(Keys::kInterval, openvdb::DoubleMetadata(checkpoint.position.interval));
    metadata.insertMeta(Keys::kTime, openvdb::DoubleMetadata(checkpoint.position.time));
    metadata.insertMeta(Keys::kSpacing, openvdb::Int64Metadata(checkpoint.position.frameSpacing));
    metadata.insertMeta(Keys::kMotion, openvdb::DoubleMetadata(checkpoint.position.motion));
    for (std::size_t i = 0; i < checkpoint.inputs.size(); ++i)
        metadata.insertMeta(inputKey(i), openvdb::StringMetadata(checkpoint.inputs[i]));
    for (const auto& [key, value] : parameters)
        metadata.insertMeta(key, openvdb::StringMetadata(value));
    for (std::size_t i = 0; i < checkpoint.parts.size(); ++i) {
        const auto& [part, box] = checkpoint.parts[i];
        const openvdb::Coord low = box.min(), high = box.max();
        const std::string text = fmt::format("{} {} {} {} {} {} {}", low[0], low[1], low[2], high[0], high[1], high[2],
                                             part.filename().string());
        metadata.insertMeta(partKey(i), openvdb::StringMetadata(text));
    }
    openvdb::GridCPtrVec grids;
    for (const VdbFile& state : checkpoint.states)
        grids.insert(grids.end(), state.grids.begin(), state.grids.end());
    writeVdb(path, grids, metadata);
}

Checkpoint readCheckpoint(const std::filesystem::path& path, const ParameterTexts& parameters)
{
    Checkpoint checkpoint;
    bool hasChecksums = false;
    try {
        hasChecksums = verifyVdb(path);
        checkpoint.states.push_back(readVdb(path));
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}; or {}", error.what(), kMend));
    }
    if (!hasChecksums) refuseCheckpoint(path, "is not as vdblic_advect writes it: its checksums are gone");
    const openvdb::MetaMap& metadata = checkpoint.states.front().metadata;
    const PositionReader position(path, metadata);
    checkpoint.position.steps = std::uint64_t(position.get<std::int64_t>(Keys::kSteps));
    checkpoint.position.interval = position.get<double>(Keys::kInterval);
    checkpoint.position.time = position.get<double>(Keys::kTime);
    checkpoint.position.frameSpacing = position.get<std::int64_t>(Keys::kSpacing);
    checkpoint.position.motion = position.get<double>(Keys::kMotion);
    checkPosition(path, checkpoint.position);
    if (const std::string creator = textMetadata(metadata, "creator"); creator != kCreator) {
        refuseCheckpoint(path,
                         fmt::format("was written by {}, this is {}: go on with that version", creator, kCreator));
    }
    for (const auto& [key, value] : parameters) {
        const std::string before = textMetadata(metadata, key);
        if (before == value) continue;
        throw ParameterError(fmt::format("{}: the run that was interrupted had {}, this one has {}: give the same, or "
                                         "{}",
                                         path.string(), shown(key, before), shown(key, value), kMend));
    }
    for (std::string input; !(input = textMetadata(metadata, inputKey(checkpoint.inputs.size()))).empty();)
        checkpoint.inputs.push_back(input);
    for (std::string part; !(part = textMetadata(metadata, partKey(checkpoint.parts.size()))).empty();)
        checkpoint.parts.push_back(partOf(path, part));
    if (!checkpoint.parts.empty()) checkpoint.states.clear();
    return checkpoint;
}

void refuseCheckpoint(const std::filesystem::path& path, const std::string& reason)
{
    throw InputError(fmt::format("{}: {}, or {}", path.string(), reason, kMend));
}

} // namespace vdblic
