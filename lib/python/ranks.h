#pragma once

#include "vdblic/core/exchange.h"

#include <pybind11/pybind11.h>

#include <cstdint>
#include <span>
#include <vector>

namespace vdblic::python {

/// The ranks of an object of Python (vdblic/ranks.py), which knows mpi4py. May be used without Python's lock.
class __attribute__((visibility("hidden"))) Ranks final : public Exchange { // as the object it holds
  public:
    explicit Ranks(pybind11::object ranks);

    [[nodiscard]] int rank() const override { return mRank; }
    [[nodiscard]] int size() const override { return mSize; }

  protected:
    std::vector<Bytes> doSwap(std::vector<Bytes> messages) override;
    std::vector<Bytes> doGather(Bytes message) override;
    Bytes doBroadcast(Bytes message, int from) override;
    void doSum(std::span<std::uint64_t> numbers) override;
    void doMax(std::span<double> numbers) override;

  private:
    template<typename T>
    void reduce(const char* how, std::span<T> numbers) const;

    pybind11::object mRanks;
    int mRank, mSize;
};

} // namespace vdblic::python
