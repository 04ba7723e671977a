#pragma once

#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>

namespace vdblic::compare {

/// The distance of two values of a type. `error` and `magnitude` may be not finite if a value is not.
///
/// kComponents is the number of components that are reported; 0 for scalars.
template<typename T>
struct Metric;

template<std::floating_point T>
struct Metric<T> {
    static constexpr int kComponents = 0;
    static double error(T a, T b) { return std::abs(double(a) - double(b)); }
    static double magnitude(T a) { return std::abs(double(a)); }
    static bool same(T a, T b) { return a == b || (std::isnan(a) && std::isnan(b)); }
    static std::string text(T a) { return fmt::format("{}", a); }
};

template<std::signed_integral T>
struct Metric<T> {
    static constexpr int kComponents = 0;
    static double error(T a, T b)
    {
        // Doubles cannot distinguish all 64-bit integers beyond 2⁵³.
        if constexpr (sizeof(T) < 8)
            return std::abs(double(a) - double(b));
        else
            return double(a > b ? std::uint64_t(a) - std::uint64_t(b) : std::uint64_t(b) - std::uint64_t(a));
    }
    static double magnitude(T a) { return std::abs(double(a)); }
    static bool same(T a, T b) { return a == b; }
    static std::string text(T a) { return fmt::format("{}", int64_t(a)); }
};

template<>
struct Metric<bool> {
    static constexpr int kComponents = 0;
    static double error(bool a, bool b) { return a == b ? 0. : 1.; }
    static double magnitude(bool a) { return a ? 1. : 0.; }
    static bool same(bool a, bool b) { return a == b; }
    static std::string text(bool a) { return a ? "true" : "false"; }
};

template<>
struct Metric<std::string> {
    static constexpr int kComponents = 0;
    static double error(const std::string& a, const std::string& b) { return a == b ? 0. : 1.; }
    static double magnitude(const std::string&) { return 1.; }
    static bool same(const std::string& a, const std::string& b) { return a == b; }
    static std::string text(const std::string& a) { return '"' + a + '"'; }
};

/// Values made of several numbers: the error is the Euclidean length of the difference.
template<typename T, typename Scalar, int kCount, int kReported>
struct TupleMetric {
    static constexpr int kComponents = kReported;
    static double error(const T& a, const T& b)
    {
        return length([&](int i) { return double(at(a, i)) - double(at(b, i)); });
    }
    static double magnitude(const T& a)
    {
        return length([&](int i) { return double(at(a, i)); });
    }
    static double componentError(const T& a, const T& b, int i) { return Metric<Scalar>::error(at(a, i), at(b, i)); }
    static bool same(const T& a, const T& b)
    {
        for (int i = 0; i < kCount; ++i) {
            if (!Metric<Scalar>::same(at(a, i), at(b, i))) return false;
        }
        return true;
    }
    static std::string text(const T& a)
    {
        std::string text = "(";
        for (int i = 0; i < kCount; ++i)
            text += (i > 0 ? ", " : "") + Metric<Scalar>::text(at(a, i));
        return text + ")";
    }

  private:
    static Scalar at(const T& a, int i)
    {
        if constexpr (requires { a.asPointer(); })
            return a.asPointer()[i];
        else
            return a[i];
    }

    template<typename Component>
    static double length(const Component& component)
    {
        double sum = 0;
        if constexpr (std::is_same_v<Scalar, double>) {
            // Squares of doubles can overflow, or underflow to 0 where the values differ.
            for (int i = 0; i < kCount; ++i)
                sum = std::hypot(sum, component(i));
        } else {
            for (int i = 0; i < kCount; ++i)
                sum += component(i) * component(i);
            sum = std::sqrt(sum);
        }
        return sum;
    }
};

template<typename S>
struct Metric<openvdb::math::Vec3<S>> : TupleMetric<openvdb::math::Vec3<S>, S, 3, 3> {
};
template<typename S>
struct Metric<openvdb::math::Quat<S>> : TupleMetric<openvdb::math::Quat<S>, S, 4, 0> {
};
template<typename S>
struct Metric<openvdb::math::Mat3<S>> : TupleMetric<openvdb::math::Mat3<S>, S, 9, 0> {
};
template<typename S>
struct Metric<openvdb::math::Mat4<S>> : TupleMetric<openvdb::math::Mat4<S>, S, 16, 0> {
};

} // namespace vdblic::compare
