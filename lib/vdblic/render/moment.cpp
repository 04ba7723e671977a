#include "vdblic/render/moment.h"

#include "vdblic/core/errors.h"
#include "vdblic/io/frame_list.h"
#include "vdblic/io/frame_pattern.h"
#include "vdblic/render/render_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace vdblic {
namespace {

/// The moments of a pattern's lines: several for each interval between frames, numbered as vdblic_advect does.
class Substeps {
  public:
    explicit Substeps(const RenderPlan& plan)
        : mPattern(plan.input.pattern), mFound(mPattern.framesOnDisk()), mSpacing(frameSpacing(plan.input)),
          mCount(plan.substeps)
    {
        if (mFound.empty()) (void)selectFrames(plan.input); // says why
    }

    /// The numbers of all pictures.
    [[nodiscard]] std::vector<std::int64_t> numbers() const
    {
        std::vector<std::int64_t> numbers;
        for (std::int64_t frame = mFound.front(); frame < mFound.back(); frame += mSpacing) {
            for (std::int64_t substep = 0; substep < mCount; ++substep)
                numbers.push_back(numberOf(frame) + substep);
        }
        numbers.push_back(last());
        return numbers;
    }
    [[nodiscard]] std::int64_t first() const { return mFound.front(); }
    [[nodiscard]] std::int64_t last() const { return numberOf(mFound.back()); }

    [[nodiscard]] Moment at(std::int64_t number) const
    {
        const std::int64_t interval = mSpacing * mCount, passed = number - first(), substep = passed % interval;
        if (number < first() || number > last() || substep >= mCount) {
            throw InputError(fmt::format("{}: there is no picture {} with `substeps` {}; they are numbered {} to {}",
                                         mPattern.text(), number, mCount, first(), last()));
        }
        const FrameFile file = fileOf(first() + passed / interval * mSpacing);
        Moment moment{.file = file, .substeps = int(mCount), .number = number};
        if (substep > 0) {
            moment.next = fileOf(file.frame + mSpacing);
            moment.share = double(substep) / double(mCount);
        }
        return moment;
    }

  private:
    [[nodiscard]] std::int64_t numberOf(std::int64_t frame) const { return first() + (frame - first()) * mCount; }
    [[nodiscard]] FrameFile fileOf(std::int64_t frame) const
    {
        FrameFile file{frame, mPattern.path(frame)};
        if (std::binary_search(mFound.begin(), mFound.end(), frame)) return file;
        throw InputError(fmt::format("frame {} is missing: {}; `frames` can select pictures elsewhere, by their "
                                     "numbers with `substeps`",
                                     frame, file.path.string()));
    }

    FramePattern mPattern;
    std::vector<std::int64_t> mFound;
    std::int64_t mSpacing, mCount;
};

} // namespace

std::vector<Moment> momentsOf(const RenderPlan& plan)
{
    std::vector<Moment> moments;
    if (plan.substeps == 1) {
        for (const FrameFile& file : selectFrames(plan.input))
            moments.push_back({.file = file});
        return moments;
    }
    const Substeps substeps(plan);
    std::vector<std::int64_t> numbers = plan.pictures.empty() ? substeps.numbers() : parseFrameList(plan.pictures);
    if (plan.input.clampFrames) {
        std::erase_if(numbers,
                      [&](std::int64_t number) { return number < substeps.first() || number > substeps.last(); });
    }
    for (const std::int64_t number : numbers)
        moments.push_back(substeps.at(number));
    return moments;
}

std::function<std::optional<Moment>()> openMoments(const RenderPlan& plan, std::istream& lines, std::size_t& count)
{
    if (plan.substeps == 1) {
        return [source = openSequence(plan.input, lines, count)]() -> std::optional<Moment> {
            const std::optional<FrameFile> file = source();
            return file ? std::optional(Moment{.file = *file}) : std::nullopt;
        };
    }
    auto moments = std::make_shared<const std::vector<Moment>>(momentsOf(plan));
    count = moments->size();
    return [moments = std::move(moments), next = std::size_t{0}]() mutable -> std::optional<Moment> {
        if (next == moments->size()) return std::nullopt;
        return (*moments)[next++];
    };
}

} // namespace vdblic
