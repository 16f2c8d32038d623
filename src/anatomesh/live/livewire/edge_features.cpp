#include "anatomesh/live/livewire/edge_features.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// The Gaussian is cut off here: beyond lie 0.3 % of it. [standard deviations; >= 2; D]
constexpr double kernel_reach = 3;
// A thread takes so many rows at a time. [rows; >= 1; B]
constexpr std::size_t rows_at_once = 64;
// The strongest zero crossings that never count as typical, since one bright pixel has as many: smoothed, it has a ring
// of them at sqrt(2) standard deviations, on both sides of the ring.
// [pixels per pixel of standard deviation; >= 0; D 2 * 2 * pi * sqrt(2)]
constexpr double ring_of_a_pixel = 17.8;
// The ring of a bright pixel that is not smoothed: its neighbours. [pixels; >= 0; D]
constexpr std::size_t smallest_ring = 8;
// The sides of an edge are looked at so far from it: nearer the smoothing mixes them.
// [standard deviations of the smoothing; 1 to 4; D a choice, measurement not recorded]
constexpr double side_distance = 2;
// TurnAngle has 16 bits. [units per turn; one value; D]
constexpr double units_per_turn = 65536;

// Half of a Gaussian kernel: the weight of its middle first.
std::vector<double> half_gaussian(double deviation_steps) {
    std::vector<double> half{1};
    if (deviation_steps <= 0) return half;
    const int radius = static_cast<int>(std::ceil(kernel_reach * deviation_steps));
    for (int n = 1; n <= radius; ++n) {
        const double x = n / deviation_steps;
        half.push_back(std::exp(-0.5 * x * x));
    }
    return half;
}

struct Weighted {
    double sum = 0, weight = 0;
};

// Smooths rows [begin, end) of a picture by normalized convolution, along rows and then along columns.
class Smoothing {
  public:
    Smoothing(const GreyPicture& picture, double deviation_mm)
        : picture_(picture),
          width_(picture.grid.size[0]),
          height_(picture.grid.size[1]),
          along_row_(half_gaussian(deviation_mm / picture.grid.step.x)),
          along_column_(half_gaussian(deviation_mm / picture.grid.step.y)) {}

    // Rounding to float takes the rounding of the sums away: equal values stay equal exactly.
    void smooth_rows(std::size_t begin, std::size_t end, std::vector<float>& smoothed) const {
        const std::size_t reach = along_column_.size() - 1;
        const std::size_t first = begin - std::min(begin, reach), last = std::min(height_, end + reach);
        std::vector<Weighted> band((last - first) * width_);
        for (std::size_t j = first; j < last; ++j) smooth_along_row(j, &band[(j - first) * width_]);
        for (std::size_t j = begin; j < end; ++j) {
            const std::size_t low = std::min(reach, j), high = std::min(reach, height_ - 1 - j);
            for (std::size_t i = 0; i < width_; ++i) {
                const Weighted* const middle = &band[(j - first) * width_ + i];
                Weighted total = *middle;
                for (std::size_t n = 1; n <= low; ++n) add(along_column_[n], *(middle - n * width_), total);
                for (std::size_t n = 1; n <= high; ++n) add(along_column_[n], *(middle + n * width_), total);
                smoothed[j * width_ + i] = total.weight > 0 ? static_cast<float>(total.sum / total.weight)
                                                            : std::numeric_limits<float>::quiet_NaN();
            }
        }
    }

  private:
    static void add(double factor, const Weighted& part, Weighted& total) {
        total.sum += factor * part.sum;
        total.weight += factor * part.weight;
    }
    void smooth_along_row(std::size_t j, Weighted* row) const {
        const float* const values = &picture_.pixels[j * width_];
        const std::size_t reach = along_row_.size() - 1;
        const auto add_value = [&](double factor, float value, Weighted& total) {
            if (!std::isfinite(value)) return;
            total.sum += factor * value;
            total.weight += factor;
        };
        for (std::size_t i = 0; i < width_; ++i) {
            Weighted& total = row[i];
            const std::size_t low = std::min(reach, i), high = std::min(reach, width_ - 1 - i);
            add_value(along_row_[0], values[i], total);
            for (std::size_t n = 1; n <= low; ++n) add_value(along_row_[n], values[i - n], total);
            for (std::size_t n = 1; n <= high; ++n) add_value(along_row_[n], values[i + n], total);
        }
    }

    const GreyPicture& picture_;
    std::size_t width_, height_;
    std::vector<double> along_row_, along_column_;
};

// First and second derivative along one axis, by differences to the neighbours that have a value.
struct Derivatives {
    double first = 0, second = 0;
};

Derivatives derivatives(double before, double here, double after, double step) {
    const bool has_before = std::isfinite(before), has_after = std::isfinite(after);
    if (has_before && has_after) {
        return {(after - before) / (2 * step), ((after - here) - (here - before)) / (step * step)};
    }
    if (has_before) return {(here - before) / step, 0};
    if (has_after) return {(after - here) / step, 0};
    return {};
}

// Values as large as floats can be have steeper gradients than floats can be.
float bounded(double derivative) {
    // Derivatives end here, so that their squares and sums are finite.
    // [grey values per mm, or per mm squared; > 0; D largest float]
    constexpr double largest = 1e38;
    return static_cast<float>(std::clamp(derivative, -largest, largest));
}

// The gradient of one row, its tangents and the Laplacian; kinds become no_value, flat or slope.
void differentiate_row(std::size_t j, const GreyPicture& picture, EdgeFeatures& features,
                       std::vector<float>& laplacian) {
    const PictureGrid& grid = features.grid;
    const std::size_t width = grid.size[0], height = grid.size[1];
    const auto value = [&](std::size_t v) -> double {
        return std::isfinite(picture.pixels[v]) ? features.smoothed[v]
                                                : std::numeric_limits<double>::quiet_NaN();
    };
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t i = 0; i < width; ++i) {
        const std::size_t v = j * width + i;
        const double here = value(v);
        if (!std::isfinite(here)) continue;
        const Derivatives x =
            derivatives(i > 0 ? value(v - 1) : none, here, i + 1 < width ? value(v + 1) : none, grid.step.x);
        const Derivatives y = derivatives(j > 0 ? value(v - width) : none, here,
                                          j + 1 < height ? value(v + width) : none, grid.step.y);
        features.gradient_x[v] = bounded(x.first);
        features.gradient_y[v] = bounded(y.first);
        laplacian[v] = bounded(x.second + y.second);
        const bool flat = features.gradient_x[v] == 0 && features.gradient_y[v] == 0;
        features.kind[v] = flat ? PixelKind::flat : PixelKind::slope;
        if (!flat) features.tangent[v] = turn_angle({-y.first, x.first});
    }
}

void find_zero_crossings_of_row(std::size_t j, const std::vector<float>& laplacian, EdgeFeatures& features) {
    const std::size_t width = features.grid.size[0], height = features.grid.size[1];
    for (std::size_t i = 0; i < width; ++i) {
        const std::size_t v = j * width + i;
        if (features.kind[v] != PixelKind::slope) continue;
        const float here = laplacian[v];
        const float left = i > 0 ? laplacian[v - 1] : here;
        const float right = i + 1 < width ? laplacian[v + 1] : here;
        const float up = j > 0 ? laplacian[v - width] : here;
        const float down = j + 1 < height ? laplacian[v + width] : here;
        const auto opposed = [](float a, float b) { return (a < 0 && b > 0) || (a > 0 && b < 0); };
        const auto crossed_to = [&](float other) {
            return opposed(here, other) && std::abs(here) <= std::abs(other);
        };
        const bool crossed =
            here == 0 ? opposed(left, right) || opposed(up, down)
                      : crossed_to(left) || crossed_to(right) || crossed_to(up) || crossed_to(down);
        if (crossed) features.kind[v] = PixelKind::zero_crossing;
    }
}

double strong_gradient(const EdgeFeatures& features, const EdgeFeatureOptions& options) {
    std::vector<float> magnitudes;
    for (std::uint32_t v = 0; v < features.kind.size(); ++v) {
        if (features.kind[v] != PixelKind::zero_crossing) continue;
        magnitudes.push_back(static_cast<float>(features.gradient_magnitude(v)));
    }
    if (magnitudes.empty()) return 0;
    const std::size_t count = magnitudes.size();
    const auto rounded_up = [](double value) { return static_cast<std::size_t>(std::ceil(value)); };
    const std::size_t ring = std::max(smallest_ring, rounded_up(ring_of_a_pixel * options.smoothing));
    const std::size_t beyond = rounded_up(static_cast<double>(count) * (1 - options.strong_percentile / 100));
    const std::size_t left_out = std::min(ring + beyond, count / 2);
    const auto strong = magnitudes.end() - 1 - static_cast<std::ptrdiff_t>(left_out);
    std::nth_element(magnitudes.begin(), strong, magnitudes.end());
    return *strong;
}

}  // namespace

TurnAngle turn_angle(Vec2 direction) {
    const double turns = std::atan2(direction.y, direction.x) / (2 * std::numbers::pi);
    return static_cast<TurnAngle>(std::lround(turns * units_per_turn));
}

double EdgeFeatures::value_at(Vec2 p) const {
    const auto along = [](double at, std::uint32_t side, std::uint32_t& low, std::uint32_t& high) {
        const double last = side - 1.0, inside = std::clamp(at, 0.0, last);
        low = static_cast<std::uint32_t>(inside);
        high = std::min(low + 1, side - 1);
        return inside - low;
    };
    Pixel low, high;
    const double x = along(p.x / grid.step.x, grid.size[0], low.i, high.i);
    const double y = along(p.y / grid.step.y, grid.size[1], low.j, high.j);
    const auto value = [&](std::uint32_t i, std::uint32_t j) -> double {
        const std::uint32_t v = grid.index({i, j});
        return kind[v] == PixelKind::no_value ? std::numeric_limits<double>::quiet_NaN() : smoothed[v];
    };
    const auto row = [&](std::uint32_t j) { return (1 - x) * value(low.i, j) + x * value(high.i, j); };
    return (1 - y) * row(low.j) + y * row(high.j);
}

EdgeFeatures::Sides EdgeFeatures::sides(std::uint32_t pixel) const {
    const double magnitude = gradient_magnitude(pixel);
    if (kind[pixel] == PixelKind::no_value || kind[pixel] == PixelKind::flat) {
        return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
    }
    const double distance = std::max(side_distance * smoothing_mm, grid.mean_step());
    const Vec2 offset = (distance / magnitude) * Vec2{gradient_x[pixel], gradient_y[pixel]};
    const Vec2 middle = grid.position(grid.pixel(pixel));
    return {value_at(middle + offset), value_at(middle - offset)};
}

Result<EdgeFeatures> find_edge_features(const GreyPicture& picture, const EdgeFeatureOptions& options,
                                        RunContext& context) {
    assert(options.smoothing >= 0 && options.smoothing <= 5);
    assert(options.strong_percentile >= 50 && options.strong_percentile <= 100);
    ANATOMESH_CHECK_STATUS(check_grey_picture(picture));
    EdgeFeatures features;
    features.grid = picture.grid;
    features.smoothing_mm = options.smoothing * picture.grid.mean_step();
    const std::size_t count = picture.grid.count(), rows = picture.grid.size[1];
    features.kind.assign(count, PixelKind::no_value);
    features.smoothed.resize(count);
    features.gradient_x.assign(count, 0);
    features.gradient_y.assign(count, 0);
    features.tangent.assign(count, 0);

    const auto for_rows = [&](const auto& body) {
        parallel_for(rows, rows_at_once, context.threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t j = begin; j < end && !context.cancelled(); ++j) body(j);
        });
    };
    const Smoothing smoothing(picture, features.smoothing_mm);
    parallel_for(rows, rows_at_once, context.threads, [&](std::size_t begin, std::size_t end) {
        if (!context.cancelled()) smoothing.smooth_rows(begin, end, features.smoothed);
    });
    std::vector<float> laplacian(count, 0);
    for_rows([&](std::size_t j) { differentiate_row(j, picture, features, laplacian); });
    for_rows([&](std::size_t j) { find_zero_crossings_of_row(j, laplacian, features); });
    if (context.cancelled()) return cancelled_error();
    features.strong_gradient = strong_gradient(features, options);
    return features;
}

}  // namespace anatomesh
