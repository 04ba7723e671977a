#pragma once

#include "vdblic/core/exchange.h"

#include <span>
#include <vector>

namespace vdblic {

/// The processes started by `mpirun` or `srun`. One object per process: it initialises and finalises MPI.
class MpiExchange final : public Exchange {
  public:
    /// @param argc, argv of main()
    MpiExchange(int& argc, char**& argv);
    ~MpiExchange() override;
    MpiExchange(const MpiExchange&) = delete;
    MpiExchange& operator=(const MpiExchange&) = delete;

    [[nodiscard]] int rank() const override { return mRank; }
    [[nodiscard]] int size() const override { return mSize; }
    /// The number of ranks that share this machine's memory.
    [[nodiscard]] int onHost() const { return mOnHost; }

  protected:
    std::vector<Bytes> doSwap(std::vector<Bytes> messages) override;
    std::vector<Bytes> doGather(Bytes message) override;
    Bytes doBroadcast(Bytes message, int from) override;
    void doSum(std::span<std::uint64_t> numbers) override;
    void doMax(std::span<double> numbers) override;

  private:
    int mRank = 0, mSize = 1, mOnHost = 1;
};

} // namespace vdblic
