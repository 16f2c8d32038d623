// StandardArithmetic: rounding to nearest and gradual underflow, for as long as it lives.
#pragma once

#include <cfenv>

namespace anatomesh {

// A program that calls the library may have set another rounding mode, or let denormal numbers be zero. Exact
// predicates and the same bytes everywhere need the defaults of IEEE 754. The constructor sets them for this thread, and
// the destructor puts the caller's back. Each thread of a parallel loop (parallel.h) has them by itself. Cost: tens of nanoseconds.
class StandardArithmetic {
  public:
    StandardArithmetic() {
        std::fegetenv(&before_);
        std::fesetenv(FE_DFL_ENV);
    }
    ~StandardArithmetic() { std::fesetenv(&before_); }
    StandardArithmetic(const StandardArithmetic&) = delete;
    StandardArithmetic& operator=(const StandardArithmetic&) = delete;

  private:
    std::fenv_t before_{};
};

}  // namespace anatomesh
