#include "anatomesh/live/livewire/livewire_training.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>

#include "anatomesh/base/plural.h"
#include "anatomesh/base/standard_arithmetic.h"

namespace anatomesh {

namespace {

// Fewer places are no typical edge. [pixels; >= 2; D a choice, measurement not recorded]
constexpr std::uint32_t least_places = 16;
// The parts of a histogram. [1; >= 8; B]
constexpr std::size_t histogram_bins = 256;
// The share of values at each end that are taken for outliers. [1; 0 to 0.2; D]
constexpr double outlying_share = 0.02;
// Silverman's rule: the width of a Gaussian, in standard deviations times the fifth root of the count.
// [1; one value; D Silverman 1986, equation 3.31]
constexpr double silverman_factor = 0.9;
// An interquartile range in standard deviations of a normal distribution. [1; one value; D]
constexpr double quartiles_apart = 1.349;
// A Gaussian is at least so wide, since another slice never has quite the same grey values.
// [1, of the gradient or of the contrast; 0 to 0.5; D a choice, measurement not recorded]
constexpr double least_width_share = 0.1;
// Pixels so far beside an edge, on both sides, show what is no edge: nearer ones still have its gradient, and farther ones
// no wire goes to. [mean pixel steps; 2 to 20; D a choice, measurement not recorded]
constexpr std::array<double, 4> steps_beside{3.0, 5.0, 7.0, 9.0};
// This share of the highest histogram counts as beside the edge everywhere: values that were hardly seen are no edge.
// [1, of the highest; > 0; D a choice, measurement not recorded]
constexpr double unseen_share = 0.02;
// A histogram reaches so far beyond the values that it is made of. [widths of the Gaussian; 2 to 5; D]
constexpr double histogram_reach = 3;

// What was seen of pixels, one entry for each.
struct Samples {
    std::vector<double> gradient, edge, bright, dark;
};

// What was seen on drawn edges and beside them.
struct DrawnSamples {
    Samples on, beside;
};

// The pixel with the strongest gradient within a distance; of equal ones the first.
std::uint32_t snapped(const EdgeFeatures& features, Pixel at, double distance_mm) {
    const PictureGrid& grid = features.grid;
    const auto low = [&](std::uint32_t place, double step) {
        return place - std::min(place, static_cast<std::uint32_t>(distance_mm / step));
    };
    const auto high = [&](std::uint32_t place, double step, std::uint32_t side) {
        return std::min(place + static_cast<std::uint32_t>(distance_mm / step), side - 1);
    };
    std::uint32_t best = grid.index(at);
    for (std::uint32_t j = low(at.j, grid.step.y); j <= high(at.j, grid.step.y, grid.size[1]); ++j) {
        for (std::uint32_t i = low(at.i, grid.step.x); i <= high(at.i, grid.step.x, grid.size[0]); ++i) {
            const std::uint32_t v = grid.index({i, j});
            if (length(grid.position({i, j}) - grid.position(at)) > distance_mm) continue;
            if (features.gradient_magnitude(v) > features.gradient_magnitude(best)) best = v;
        }
    }
    return best;
}

// Returns whether the pixel has a gradient and values on both sides; nothing is added else.
bool add_pixel(const EdgeFeatures& features, std::uint32_t v, Samples& samples) {
    const EdgeFeatures::Sides sides = features.sides(v);
    if (!std::isfinite(sides.bright) || !std::isfinite(sides.dark)) return false;
    samples.gradient.push_back(features.gradient_magnitude(v));
    samples.edge.push_back(features.smoothed[v]);
    samples.bright.push_back(sides.bright);
    samples.dark.push_back(sides.dark);
    return true;
}

void add_place(const EdgeFeatures& features, std::uint32_t v, DrawnSamples& samples) {
    if (!add_pixel(features, v, samples.on)) return;
    const PictureGrid& grid = features.grid;
    const Vec2 across = (grid.mean_step() / features.gradient_magnitude(v)) *
                        Vec2{features.gradient_x[v], features.gradient_y[v]};
    for (const double steps : steps_beside) {
        for (const double signed_steps : {-steps, steps}) {
            const NearestPixel beside = grid.nearest(grid.position(grid.pixel(v)) + signed_steps * across);
            if (beside.inside) add_pixel(features, grid.index(beside.pixel), samples.beside);
        }
    }
}

// Adds the places along one segment, at half pixels; `last` is the pixel that was added before.
void add_segment(const DrawnPath& path, Vec2 a, Vec2 b, double snap_mm, std::uint32_t& last,
                 DrawnSamples& samples) {
    const PictureGrid& grid = path.features->grid;
    // A segment that leaves the picture says nothing of an edge there.
    if (!grid.nearest(a).inside || !grid.nearest(b).inside) return;
    const double halves = 2 * std::max(std::abs(b.x - a.x) / grid.step.x, std::abs(b.y - a.y) / grid.step.y);
    const int parts = std::max(1, static_cast<int>(std::ceil(halves)));
    for (int n = 0; n <= parts; ++n) {
        const Vec2 p = a + (static_cast<double>(n) / parts) * (b - a);
        const std::uint32_t v = snapped(*path.features, grid.nearest(p).pixel, snap_mm);
        if (v == last) continue;
        last = v;
        add_place(*path.features, v, samples);
    }
}

void add_path(const DrawnPath& path, const LivewireTrainingOptions& options, DrawnSamples& samples) {
    const std::size_t count = path.points.size();
    const double snap_mm = options.snap * path.features->grid.mean_step();
    auto last = static_cast<std::uint32_t>(path.features->grid.count());
    const std::size_t segments = count < 2 ? 0 : path.closed ? count : count - 1;
    for (std::size_t n = 0; n < segments; ++n) {
        add_segment(path, path.points[n], path.points[(n + 1) % count], snap_mm, last, samples);
    }
}

double quantile(const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1) + 0.5)];
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return quantile(values, 0.5);
}

double standard_deviation(const std::vector<double>& values) {
    double mean = 0, squares = 0;
    for (const double value : values) mean += value;
    mean /= static_cast<double>(values.size());
    for (const double value : values) squares += (value - mean) * (value - mean);
    return std::sqrt(squares / static_cast<double>(values.size()));
}

// The histogram of the values in the feature's range, smoothed by a Gaussian; its sum is that of one value.
std::vector<double> smooth_histogram(const std::vector<double>& values, const FeatureCost& feature,
                                     double width) {
    const double bin = (feature.high - feature.low) / histogram_bins;
    std::vector<double> histogram(histogram_bins, 0), smooth(histogram_bins, 0);
    for (const double value : values) {
        if (value < feature.low || value >= feature.high) continue;
        const auto n = static_cast<std::size_t>((value - feature.low) / bin);
        histogram[std::min(n, histogram_bins - 1)] += 1 / static_cast<double>(values.size());
    }
    for (std::size_t n = 0; n < histogram_bins; ++n) {
        for (std::size_t m = 0; m < histogram_bins; ++m) {
            const double x = (static_cast<double>(n) - static_cast<double>(m)) * bin / width;
            smooth[n] += histogram[m] * std::exp(-0.5 * x * x);
        }
    }
    return smooth;
}

// Requires: `on` is not empty.
FeatureCost feature_cost(std::vector<double> on, const std::vector<double>& beside, double least_width) {
    std::sort(on.begin(), on.end());
    const double spread =
        std::min(standard_deviation(on), (quantile(on, 0.75) - quantile(on, 0.25)) / quartiles_apart);
    const double count = static_cast<double>(on.size());
    const double width = std::max(silverman_factor * spread * std::pow(count, -0.2), least_width);
    FeatureCost feature;
    feature.low = quantile(on, outlying_share) - histogram_reach * width;
    feature.high = quantile(on, 1 - outlying_share) + histogram_reach * width;
    if (!(feature.high > feature.low)) return feature;  // one value alone, and no width
    const std::vector<double> edge = smooth_histogram(on, feature, width);
    const std::vector<double> other = smooth_histogram(beside, feature, width);
    const double unseen = unseen_share * *std::max_element(edge.begin(), edge.end());
    for (std::size_t n = 0; n < histogram_bins; ++n) {
        feature.costs.push_back(static_cast<float>((other[n] + unseen) / (edge[n] + other[n] + unseen)));
    }
    return feature;
}

Status check_points(const DrawnPath& path) {
    for (std::size_t n = 0; n < path.points.size(); ++n) {
        ANATOMESH_CHECK_STATUS(check_picture_point(path.points[n], "point " + std::to_string(n)));
    }
    return Nothing{};
}

}  // namespace

double FeatureCost::cost(double value) const {
    if (costs.empty()) return 0;
    if (!(value >= low && value < high)) return 1;
    const auto n = static_cast<std::size_t>((value - low) / (high - low) * static_cast<double>(costs.size()));
    return costs[std::min(n, costs.size() - 1)];
}

Result<LivewireTraining> train_livewire(std::span<const DrawnPath> paths,
                                        const LivewireTrainingOptions& options) {
    assert(options.snap >= 0 && options.snap <= 5);
    const StandardArithmetic arithmetic;
    DrawnSamples samples;
    for (const DrawnPath& path : paths) {
        assert(path.features != nullptr);
        ANATOMESH_CHECK_STATUS(check_points(path));
        add_path(path, options, samples);
    }
    const Samples &on = samples.on, &beside = samples.beside;
    const std::size_t places = on.gradient.size();
    if (places < least_places) {
        return Error{ErrorKind::input,
                     "E-LIV-108",
                     "the drawn paths lead through " + counted(places, "pixel") +
                         " with an edge, which is too little to learn from",
                     {},
                     "draw a longer path; " + std::to_string(least_places) + " pixels suffice"};
    }
    const double least_contrast = least_width_share * std::abs(median(on.bright) - median(on.dark));
    LivewireTraining training;
    training.places = static_cast<std::uint32_t>(places);
    training.gradient = feature_cost(on.gradient, beside.gradient, least_width_share * median(on.gradient));
    training.edge = feature_cost(on.edge, beside.edge, least_contrast);
    training.bright = feature_cost(on.bright, beside.bright, least_contrast);
    training.dark = feature_cost(on.dark, beside.dark, least_contrast);
    return training;
}

}  // namespace anatomesh
