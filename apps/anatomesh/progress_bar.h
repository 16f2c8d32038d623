// ProgressBar: how far the work is, on a terminal: one line on standard error, rewritten in place.
#pragma once

#include <chrono>
#include <string>

namespace anatomesh {

// Silent for the first second and when standard error is no terminal. The destructor wipes the line.
class ProgressBar {
  public:
    ProgressBar();
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    // Begins a part of the work, which usually takes the time from share `from` to share `to` of the whole.
    void begin(const std::string& part, double from, double to);
    // `share` of the part is done, 0 to 1.
    void update(double share);

  private:
    using Clock = std::chrono::steady_clock;

    std::string part_;
    double from_ = 0, to_ = 1;
    bool terminal_;
    bool drawn_ = false;
    Clock::time_point start_ = Clock::now();
    Clock::time_point last_ = start_;
};

}  // namespace anatomesh
