// Result: a value, or the reason why bad data did not give one.
//
// Three kinds of wrong are kept apart. A caller's broken promise is an assert. Bad data is an Error in a
// Result, with a code and a place. A blemish that was mended or tolerated is a Warning, counted and reported.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace anatomesh {

// The kind of an error; the numbers are the exit codes of the command line.
enum class ErrorKind : int {
    usage = 2,       // the command, an option or its value
    input = 3,       // the content of an input
    geometry = 4,    // the input is readable, but no correct model can be made of it
    limit = 5,       // a stated limit, memory
    file = 6,        // the file system
    internal = 7,    // a check of our own result failed
    cancelled = 130  // stopped by the user
};

// A place in the input. Empty fields are unknown or do not apply.
struct Place {
    std::string file;       // as the user named it
    std::string slice;      // "12", or "z = 34.5 mm"
    std::string structure;  // name, or number when it has none
    std::string contour;    // index of the contour, and of the point: "17", "17, point 203"
    std::string value;      // the offending value as text
};

// What was wrong with the data. `code` is stable and documented (E-<room>-<nnn>, as in "E-RTS-005").
struct Error {
    ErrorKind kind = ErrorKind::internal;
    std::string code;
    std::string message;  // one sentence, no trailing full stop
    Place place;
    std::string next_step;  // what the user can do now; may be empty
};

// A blemish of the input that did not stop the run. `code` is stable (W-<room>-<nnn>).
struct Warning {
    std::string code;
    std::string message;
    Place place;
    std::string what_was_done;
};

// Returns one line: "E-RTS-005 liver.dcm, structure GTV, contour 17: 3 values expected ... (next: ...)".
std::string to_line(const Error& error);
std::string to_line(const Warning& warning);

// Either a T or an Error. Requires: value() only when ok(), error() only when not.
template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    bool ok() const { return state_.index() == 0; }
    explicit operator bool() const { return ok(); }

    T& value() & {
        assert(ok());
        return *std::get_if<0>(&state_);
    }
    const T& value() const& {
        assert(ok());
        return *std::get_if<0>(&state_);
    }
    T&& value() && {
        assert(ok());
        return std::move(*std::get_if<0>(&state_));
    }
    const Error& error() const& {
        assert(!ok());
        return *std::get_if<1>(&state_);
    }
    Error&& error() && {
        assert(!ok());
        return std::move(*std::get_if<1>(&state_));
    }

  private:
    std::variant<T, Error> state_;
};

struct Nothing {};
using Status = Result<Nothing>;

}  // namespace anatomesh

// Gives the value of a Result to `declaration`, or returns its error from the enclosing function.
//   ANATOMESH_TRY(auto mesh, tetrahedralize(points, context));
#define ANATOMESH_CONCAT_(a, b) a##b
#define ANATOMESH_CONCAT(a, b) ANATOMESH_CONCAT_(a, b)
#define ANATOMESH_TRY_(name, declaration, ...)      \
    auto name = (__VA_ARGS__);                      \
    if (!name.ok()) return std::move(name).error(); \
    declaration = std::move(name).value()
#define ANATOMESH_TRY(declaration, ...) \
    ANATOMESH_TRY_(ANATOMESH_CONCAT(try_result_, __LINE__), declaration, __VA_ARGS__)
#define ANATOMESH_CHECK_STATUS_(name, ...) \
    auto name = (__VA_ARGS__);             \
    if (!name.ok()) return std::move(name).error()
#define ANATOMESH_CHECK_STATUS(...) \
    ANATOMESH_CHECK_STATUS_(ANATOMESH_CONCAT(try_status_, __LINE__), __VA_ARGS__)
