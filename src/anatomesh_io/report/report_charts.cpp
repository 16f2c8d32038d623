#include "anatomesh_io/report/report_charts.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/base/number_text.h"
#include "anatomesh_io/report/html_text.h"

namespace anatomesh {

namespace {

// A chart is so wide in its own units, which the page scales. [px; > 0; D]
constexpr double width = 520;
// A chart is so high. [px; > 0; D]
constexpr double height = 210;
// The numbers of the vertical axis need this margin. [px; >= 0; D]
constexpr double left = 52;
// The last number of the horizontal axis needs this margin. [px; >= 0; D]
constexpr double right = 12;
// The highest number of the vertical axis needs this margin. [px; >= 0; D]
constexpr double top = 10;
// The numbers and the name of the horizontal axis need this margin. [px; >= 0; D]
constexpr double bottom = 38;

std::string attribute(const char* name, double value) {
    return std::string(" ") + name + "=\"" + fixed_text(value, 2) + "\"";
}

std::string line(const char* kind, double x1, double y1, double x2, double y2) {
    return std::string("<line class=\"") + kind + "\"" + attribute("x1", x1) + attribute("y1", y1) +
           attribute("x2", x2) + attribute("y2", y2) + "/>";
}

std::string text(double x, double y, const char* anchor, const std::string& content) {
    return "<text" + attribute("x", x) + attribute("y", y) + " text-anchor=\"" + anchor + "\">" + content +
           "</text>";
}

// 1, 2 or 5 times a power of ten, so that at most four such steps make up the highest bar.
double count_step(double highest) {
    const double raw = std::max(highest / 4, 1.0);
    const double power = std::pow(10.0, std::floor(std::log10(raw)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * power >= raw) return factor * power;
    }
    return 10 * power;
}

}  // namespace

std::string histogram_svg(const Histogram& histogram, const ChartOptions& options) {
    std::uint64_t most = 0;
    for (const std::uint64_t count : histogram.counts) most = std::max(most, count);
    const double plot_width = width - left - right, plot_height = height - top - bottom;
    const double step = count_step(static_cast<double>(most));
    const double highest = std::max(step * std::ceil(static_cast<double>(most) / step), 1.0);
    const auto x_of = [&](double value) {
        return left + plot_width * (value - histogram.low) / (histogram.high - histogram.low);
    };
    const auto y_of = [&](double count) { return top + plot_height * (1 - count / highest); };

    std::string svg = "<svg class=\"chart\" viewBox=\"0 0 520 210\" role=\"img\" aria-label=\"Histogram: " +
                      std::string(options.label) + "\">";
    for (double count = 0; count <= highest; count += step) {
        svg += line("gridline", left, y_of(count), width - right, y_of(count));
        svg += text(left - 7, y_of(count) + 4, "end", grouped(static_cast<std::uint64_t>(count)));
    }
    const double bin = (histogram.high - histogram.low) / static_cast<double>(histogram.counts.size());
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
        const double from = histogram.low + static_cast<double>(i) * bin, middle = from + bin / 2;
        const bool bad = options.bad_above ? middle > options.bound : middle < options.bound;
        const double y = y_of(static_cast<double>(histogram.counts[i]));
        if (histogram.counts[i] == 0) continue;
        // A single cell is still seen.
        const double bar = std::max(top + plot_height - y, 1.5);
        svg += std::string("<rect class=\"") + (bad ? "over" : "ok") + "\"" +
               attribute("x", x_of(from) + 0.5) + attribute("y", top + plot_height - bar) +
               attribute("width", std::max(x_of(from + bin) - x_of(from) - 1, 0.5)) +
               attribute("height", bar) + "><title>" + fixed_text(from, 2) + " to " +
               fixed_text(from + bin, 2) + ": " + grouped(histogram.counts[i]) + "</title></rect>";
    }
    svg += line("axis", left, top + plot_height, width - right, top + plot_height);
    const double first = std::ceil(histogram.low / options.tick) * options.tick;
    for (int k = 0; first + k * options.tick <= histogram.high + 1e-9; ++k) {
        const double value = first + k * options.tick;
        svg += text(x_of(value), height - bottom + 15, "middle", fixed_text(value, options.tick_decimals));
    }
    svg += line("bound", x_of(options.bound), top, x_of(options.bound), top + plot_height);
    svg += text(left + plot_width / 2, height - 6, "middle", options.label);
    return svg + "</svg>";
}

}  // namespace anatomesh
