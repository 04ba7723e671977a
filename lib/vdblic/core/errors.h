#pragma once

#include <stdexcept>

namespace vdblic {

/// Errors that a user can mend. Every message names the file, grid or parameter (its key in backticks), the value and
/// the remedy.
class Error : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A parameter is out of range or contradicts another. Tools exit with 2.
class ParameterError : public Error {
  public:
    using Error::Error;
};

/// An input file is missing or unreadable, or has the wrong content. Tools exit with 3.
class InputError : public Error {
  public:
    using Error::Error;
};

/// An output could not be written. Tools exit with 4.
class OutputError : public Error {
  public:
    using Error::Error;
};

} // namespace vdblic
