#include "ranks.h"

#include <pybind11/numpy.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

namespace vdblic::python {

namespace py = pybind11;

Ranks::Ranks(py::object ranks)
    : mRanks(std::move(ranks)), mRank(mRanks.attr("rank").cast<int>()), mSize(mRanks.attr("size").cast<int>())
{
}

std::vector<Exchange::Bytes> Ranks::doSwap(std::vector<Bytes> messages)
{
    const py::gil_scoped_acquire acquire;
    py::list given;
    for (Bytes& message : messages)
        given.append(py::bytes(std::exchange(message, {})));
    const py::list taken = mRanks.attr("swap")(given);
    std::vector<Bytes> received;
    for (const py::handle& message : taken)
        received.push_back(message.cast<std::string>());
    return received;
}

std::vector<Exchange::Bytes> Ranks::doGather(Bytes message)
{
    std::vector<Bytes> messages(static_cast<std::size_t>(mSize));
    messages.front() = std::move(message);
    messages = doSwap(std::move(messages));
    return mRank == 0 ? messages : std::vector<Bytes>();
}

Exchange::Bytes Ranks::doBroadcast(Bytes message, int from)
{
    std::vector<Bytes> messages(static_cast<std::size_t>(mSize));
    if (mRank == from) std::fill(messages.begin(), messages.end(), message);
    return doSwap(std::move(messages))[std::size_t(from)];
}

template<typename T>
void Ranks::reduce(const char* how, std::span<T> numbers) const
{
    const py::gil_scoped_acquire acquire;
    const py::array_t<T> given(py::ssize_t(numbers.size()), numbers.data());
    const auto taken = py::array_t<T, py::array::c_style | py::array::forcecast>(mRanks.attr(how)(given));
    std::copy_n(taken.data(), numbers.size(), numbers.begin());
}

void Ranks::doSum(std::span<std::uint64_t> numbers)
{
    reduce("sum", numbers);
}

void Ranks::doMax(std::span<double> numbers)
{
    reduce("max", numbers);
}

} // namespace vdblic::python
