#include "vdblic/render/frames_in_flight.h"

#include "vdblic/core/errors.h"
#include "vdblic/core/exchange.h"
#include "vdblic/core/memory.h"
#include "vdblic/core/system_memory.h"
#include "vdblic/core/threads.h"
#include "vdblic/io/sequence.h"
#include "vdblic/io/texture_name.h"
#include "vdblic/io/vdb_file.h"
#include "vdblic/io/vdb_header.h"
#include "vdblic/render/moment.h"
#include "vdblic/render/render_plan.h"
#include "vdblic/render/view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <set>
#include <string>
#include <vector>

namespace vdblic {
namespace {

/// Collective. @throws InputError if a rank sees other frames than rank 0
void checkSameFrames(const std::vector<Moment>& moments, Exchange& exchange)
{
    std::vector<std::int64_t> own, differing;
    for (const Moment& moment : moments)
        own.push_back(moment.number);
    const std::vector<std::int64_t> first = exchange.join(exchange.isFirst() ? own : std::vector<std::int64_t>{});
    std::set_symmetric_difference(own.begin(), own.end(), first.begin(), first.end(), std::back_inserter(differing));
    if (differing.empty()) return;
    throw InputError(fmt::format("frame {}: of the ranks 0 and {} one does not see its file: run again when the file "
                                 "system shows the sequence to all machines",
                                 differing.front(), exchange.rank()));
}

} // namespace

double frameBytes(const PicturePlan& plan, const FrameFile& file)
{
    try {
        const VdbHeader header = readVdbHeader(file.path);
        const std::string name = textureName(header.metadata, plan.texture);
        for (const openvdb::GridBase::Ptr& grid : header.grids) {
            if (grid->getName() == name)
                return numericMetadata(*grid, "file_voxel_count").value_or(0) * bytesPerVoxel(plan);
        }
    } catch (const InputError&) { // is reported at the frame's turn
    }
    return 0;
}

double availableMemory()
{
    return double(std::min(freeMemory(), memoryLimit()));
}

std::size_t framesInFlight(double frameBytes)
{
    return framesInFlight(frameBytes, threadCount(), availableMemory());
}

std::size_t framesInFlight(double frameBytes, std::size_t threads, double freeBytes)
{
    const double fitting = freeBytes / 2 / std::max(frameBytes, 1.0);
    return fitting < double(threads) ? std::max(std::size_t(fitting), std::size_t(1)) : threads;
}

bool ranksShareFrames(const RenderPlan& plan, Exchange& exchange)
{
    bool share = false;
    exchange.together([&] {
        if (exchange.isAlone()) return;
        const std::vector<Moment> moments = momentsOf(plan);
        checkSameFrames(moments, exchange);
        double most = 0;
        std::set<std::int64_t> frames;
        for (const Moment& moment : moments) {
            if (frames.insert(moment.file.frame).second) most = std::max(most, frameBytes(plan.picture, moment.file));
        }
        share = exchange.any(moments.size() < std::size_t(exchange.size()) || most > double(memoryLimit()) / 2);
    });
    return share;
}

} // namespace vdblic
