#include "cli/shared_frames.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace vdblic::cli {
namespace {

/// Records a rank's reports, each with a letter for its kind, so that another rank can replay them.
class KeptReports : public Reporter {
  public:
    explicit KeptReports(const Reporter& stops) : mStops(stops) {}

    void warn(std::string_view message) override { keep('w', message); }
    void finished(const std::filesystem::path& output) override { keep('f', output.string()); }
    [[nodiscard]] bool stopRequested() const override { return mStops.stopRequested(); }

    [[nodiscard]] const std::string& text() const { return mText; }

    static void replay(const std::string& text, Reporter& to)
    {
        for (std::size_t at = 0; at < text.size();) {
            const std::size_t end = text.find('\0', at);
            const std::string message = text.substr(at + 1, end - at - 1);
            text[at] == 'w' ? to.warn(message) : to.finished(message);
            at = end + 1;
        }
    }

  private:
    void keep(char kind, std::string_view message)
    {
        mText += kind;
        mText += message;
        mText += '\0';
    }

    const Reporter& mStops;
    std::string mText;
};

/// A rank's share of the frames: every n-th.
std::string shareOf(const std::vector<std::int64_t>& frames, const Exchange& exchange)
{
    std::vector<std::int64_t> mine;
    for (auto i = std::size_t(exchange.rank()); i < frames.size(); i += std::size_t(exchange.size()))
        mine.push_back(frames[i]);
    return fmt::format("{}", fmt::join(mine, ","));
}

} // namespace

void shareFrames(Exchange& exchange, const std::vector<std::int64_t>& frames, Reporter& reporter,
                 const std::function<void(const std::string& mine, Reporter& reporter)>& job)
{
    KeptReports kept(reporter);
    std::exception_ptr error;
    try {
        const std::string mine = shareOf(frames, exchange);
        if (!mine.empty()) job(mine, exchange.isFirst() ? reporter : kept);
    } catch (...) {
        error = std::current_exception();
    }
    try {
        for (const Exchange::Bytes& text : exchange.gather(kept.text()))
            KeptReports::replay(text, reporter);
        if (error) std::rethrow_exception(error);
        exchange.agree();
    } catch (...) {
        exchange.fail(std::current_exception());
        throw;
    }
}

} // namespace vdblic::cli
