#pragma once

#include "vdblic/core/exchange.h"

#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace vdblic {

/// Append values to a message.
template<typename T>
void put(Exchange::Bytes& message, const T* values, std::size_t count)
{
    static_assert(std::is_trivially_copyable_v<T>);
    message.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}
template<typename T>
void put(Exchange::Bytes& message, const T& value)
{
    put(message, &value, 1);
}

/// Reads a message in the order in which it was written.
class MessageReader {
  public:
    explicit MessageReader(const Exchange::Bytes& message) : mMessage(message) {}

    [[nodiscard]] bool atEnd() const { return mAt == mMessage.size(); }

    template<typename T>
    void get(T* values, std::size_t count)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        if (count > (mMessage.size() - mAt) / sizeof(T)) throw std::logic_error("a message between ranks is too short");
        if (count > 0) std::memcpy(static_cast<void*>(values), mMessage.data() + mAt, count * sizeof(T));
        mAt += count * sizeof(T);
    }
    template<typename T>
    [[nodiscard]] T get()
    {
        T value;
        get(&value, 1);
        return value;
    }

  private:
    const Exchange::Bytes& mMessage;
    std::size_t mAt = 0;
};

} // namespace vdblic
