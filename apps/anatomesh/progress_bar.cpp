#include "progress_bar.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace anatomesh {

namespace {

// The bar has so many characters, so that a line of 80 holds it with its text. [characters; 1 to 60; D]
constexpr int bar_width = 24;

std::string bar_text(double share) {
    const int full = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * bar_width));
    return "[" + std::string(static_cast<std::size_t>(full), '#') +
           std::string(static_cast<std::size_t>(bar_width - full), '.') + "]";
}

std::string time_text(double seconds) {
    const long whole = std::lround(std::max(1.0, seconds));
    return whole < 60 ? fmt::format("{} s", whole) : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

std::size_t terminal_width() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

void write_to_terminal(const std::string& text) {
    // A terminal that is gone takes nothing; the work goes on without a bar.
    if (::write(STDERR_FILENO, text.data(), text.size()) < 0) return;
}

}  // namespace

ProgressBar::ProgressBar() : terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
    if (drawn_) write_to_terminal("\r\x1b[K");
}

void ProgressBar::begin(const std::string& part, double from, double to) {
    part_ = part;
    from_ = from;
    to_ = to;
    update(0);
}

void ProgressBar::update(double share) {
    if (!terminal_) return;
    const auto now = Clock::now();
    using Seconds = std::chrono::duration<double>;
    const double elapsed = Seconds(now - start_).count();
    // Nothing for short work; ten pictures a second are enough for long work.
    if (elapsed < 1.0 || (drawn_ && Seconds(now - last_).count() < 0.1)) return;
    const double whole = from_ + (to_ - from_) * std::clamp(share, 0.0, 1.0);
    std::string line = fmt::format("{} {:3.0f} %  {}", bar_text(whole), 100 * whole, part_);
    if (whole > 0.02) line += fmt::format(", {} left", time_text(elapsed * (1 - whole) / whole));
    if (line.size() >= terminal_width()) line.resize(terminal_width() - 1);
    write_to_terminal("\r\x1b[K" + line);
    drawn_ = true;
    last_ = now;
}

}  // namespace anatomesh
