// ProgressBar: how far the work is, on a terminal: one line on standard error, rewritten in place.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace anatomesh {

// Stages of the work with their usual share of the time, in order. Shares need not sum to 1.
using StageShares = std::vector<std::pair<std::string, double>>;

// Silent for the first second and when standard error is no terminal. A stage that is not in the list shows
// its own progress without a time left. The destructor wipes the line.
class ProgressBar {
  public:
    explicit ProgressBar(StageShares shares);
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    // `share` of the stage is done, 0 to 1.
    void update(const std::string& stage, double share);

  private:
    using Clock = std::chrono::steady_clock;

    double whole_share(const std::string& stage, double share) const;  // of all work; negative when not known

    StageShares shares_;
    bool terminal_;
    bool drawn_ = false;
    Clock::time_point start_ = Clock::now();
    Clock::time_point last_ = start_;
};

}  // namespace anatomesh
