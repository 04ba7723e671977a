#pragma once

#include "options.h"
#include "vdblic/core/reporter.h"
#include "vdblic/run/advect_params.h"

#include <condition_variable>
#include <exception>
#include <filesystem>
#include <mutex>
#include <optional>
#include <queue>
#include <streambuf>
#include <string>
#include <thread>

namespace vdblic::python {

[[nodiscard]] AdvectParams advectParams(const Options& options); ///< @throws ParameterError

/// advectSequence() in a thread of its own, which waits for its inputs and until its outputs are taken.
///
/// With the input pattern `-` the run asks for paths. next() and answer() are called by one thread.
class AdvectionRun : private Reporter, private std::streambuf {
  public:
    explicit AdvectionRun(AdvectParams params);
    ~AdvectionRun() override; ///< stops the run
    AdvectionRun(const AdvectionRun&) = delete;
    AdvectionRun& operator=(const AdvectionRun&) = delete;

    enum class Kind { kNothing, kNeeds, kFinished, kSaid, kWarned, kDone };
    struct Event {
        Kind kind = Kind::kNothing;
        std::string text; ///< path of the finished output, or message
    };
    /// What happens next; kNothing after a tenth of a second. A finished output is the caller's from then on.
    /// @throws what the run threw
    Event next();
    /// The path that the run needs; empty at the end of the inputs.
    void answer(const std::string& path);
    void stop();

  private:
    void say(std::string_view message) override { tell({Kind::kSaid, std::string(message)}); }
    void warn(std::string_view message) override { tell({Kind::kWarned, std::string(message)}); }
    void finished(const std::filesystem::path& output) override;
    [[nodiscard]] bool stopRequested() const override;
    int_type underflow() override;
    void tell(Event event);

    AdvectParams mParams;
    mutable std::mutex mMutex;
    std::condition_variable mChanged;
    std::queue<Event> mEvents;
    std::optional<std::string> mAnswer;
    std::string mLine;
    bool mStopped = false, mEnded = false;
    std::exception_ptr mError;
    std::thread mThread; // last member: it uses the others
};

} // namespace vdblic::python
