// How well the rule between slices predicts slices that were left out: every n-th slice of the input is kept,
// and what is drawn on the others is compared with the program's field, with the nearest slice, and with
// shape-based interpolation (Raya and Udupa, IEEE Trans. Med. Imaging 9, 1990; here of exact signed
// distances). For every left-out slice and structure drawn on both kept slices round it: Dice, and the mean
// distance between the boundary pixels, both ways; 10 mm for each pixel where one of the two is empty. Prints
// rows of a Markdown table. --cut and --leave-out are for planes in any position (any_planes.h).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/field/slice/distance_map.h"
#include "anatomesh/field/slice/slice_regions.h"
#include "anatomesh/input_options.h"
#include "anatomesh/read_input.h"
#include "anatomesh/reconcile_options.h"
#include "any_planes.h"

namespace anatomesh {

namespace {

constexpr double empty_distance = 10;  // mm, for a boundary pixel without a counterpart

// A region on a grid of square pixels.
struct Mask {
    PixelGrid grid;
    std::vector<std::uint8_t> inside;

    explicit Mask(const PixelGrid& g) : grid(g), inside(static_cast<std::size_t>(g.nx) * g.ny, 0) {}
    Vec2 point(std::size_t i) const {
        return grid.low + Vec2{static_cast<double>(i % grid.nx) * grid.step.x,
                               static_cast<double>(i / grid.nx) * grid.step.y};
    }
    std::size_t count() const {
        return static_cast<std::size_t>(std::count(inside.begin(), inside.end(), std::uint8_t{1}));
    }
    // Pixels inside with a neighbour that is not; the grid has a margin.
    std::vector<std::size_t> boundary() const {
        std::vector<std::size_t> found;
        for (std::size_t i = 0; i < inside.size(); ++i) {
            if (!inside[i]) continue;
            const bool whole = inside[i - 1] && inside[i + 1] && inside[i - grid.nx] && inside[i + grid.nx];
            if (!whole) found.push_back(i);
        }
        return found;
    }
};

// Squared distances in pixels along one line (Felzenszwalb and Huttenlocher, Theory Comput. 8, 2012).
void distance_pass(std::vector<double>& line) {
    const std::size_t n = line.size();
    std::vector<std::size_t> parabola(n, 0);
    std::vector<double> from(n + 1, 0), values = line;
    constexpr double infinite = 1e20;
    std::size_t k = 0;
    from[0] = -infinite;
    from[1] = infinite;
    for (std::size_t q = 1; q < n; ++q) {
        const auto meet = [&](std::size_t p) {
            const double a = static_cast<double>(q), b = static_cast<double>(p);
            return (values[q] + a * a - values[p] - b * b) / (2 * (a - b));
        };
        double s = meet(parabola[k]);
        while (k > 0 && s <= from[k]) s = meet(parabola[--k]);
        if (s > from[k]) ++k;
        parabola[k] = q;
        from[k] = k == 0 ? -infinite : s;
        from[k + 1] = infinite;
    }
    k = 0;
    for (std::size_t q = 0; q < n; ++q) {
        while (from[k + 1] < static_cast<double>(q)) ++k;
        const double d = static_cast<double>(q) - static_cast<double>(parabola[k]);
        line[q] = d * d + values[parabola[k]];
    }
}

std::vector<double> squared_distances(const PixelGrid& grid, const std::vector<std::size_t>& to) {
    std::vector<double> squared(static_cast<std::size_t>(grid.nx) * grid.ny, 1e12);
    for (const std::size_t i : to) squared[i] = 0;
    std::vector<double> line(grid.ny);
    for (std::size_t x = 0; x < grid.nx; ++x) {
        for (std::size_t y = 0; y < grid.ny; ++y) line[y] = squared[y * grid.nx + x];
        distance_pass(line);
        for (std::size_t y = 0; y < grid.ny; ++y) squared[y * grid.nx + x] = line[y];
    }
    line.resize(grid.nx);
    for (std::size_t y = 0; y < grid.ny; ++y) {
        const auto row = squared.begin() + static_cast<std::ptrdiff_t>(y * grid.nx);
        std::copy_n(row, grid.nx, line.begin());
        distance_pass(line);
        std::copy(line.begin(), line.end(), row);
    }
    return squared;
}

class Score {
  public:
    void add(const Mask& predicted, const Mask& truth) {
        const std::size_t p = predicted.count(), t = truth.count();
        if (p + t == 0) return;
        std::size_t both = 0;
        for (std::size_t i = 0; i < truth.inside.size(); ++i) both += predicted.inside[i] & truth.inside[i];
        dice_ += 2.0 * static_cast<double>(both) / static_cast<double>(p + t);
        ++sections_;
        if (p == 0 || t == 0) {
            distance_ += empty_distance * static_cast<double>(p + t);
            pixels_ += p + t;
            return;
        }
        const std::vector<std::size_t> a = predicted.boundary(), b = truth.boundary();
        const std::vector<double> to_b = squared_distances(truth.grid, b),
                                  to_a = squared_distances(truth.grid, a);
        for (const std::size_t i : a) distance_ += std::sqrt(to_b[i]) * truth.grid.step.x;
        for (const std::size_t i : b) distance_ += std::sqrt(to_a[i]) * truth.grid.step.x;
        pixels_ += a.size() + b.size();
    }
    std::string text() const {
        return fmt::format("{:.4f} | {:.3f}", dice_ / static_cast<double>(sections_),
                           distance_ / static_cast<double>(pixels_));
    }
    std::size_t sections() const { return sections_; }

  private:
    double dice_ = 0, distance_ = 0;
    std::size_t sections_ = 0, pixels_ = 0;
};

// The kept slices with the regions drawn on them, by position along the common normal.
class KeptSlices {
  public:
    explicit KeptSlices(const ContourSet& set) : frame_(set.slices.front().plane) {
        for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
            Level level{frame_.signed_distance(set.slices[k].plane.origin), {}};
            level.maps.resize(set.structures.size());
            for (SliceRegion& region : slice_regions(set, k, frame_))
                level.maps[region.structure].emplace(std::move(region.edges), reach);
            levels_.push_back(std::move(level));
        }
        std::sort(levels_.begin(), levels_.end(), [](const Level& a, const Level& b) { return a.z < b.z; });
    }
    const Plane& frame() const { return frame_; }

    struct Level {
        double z = 0;
        std::vector<std::optional<DistanceMap>> maps;
        double distance(std::uint32_t structure, Vec2 q) const {
            return maps[structure] ? maps[structure]->value(q) : reach;
        }
    };
    // The two slices round z, strictly between them; null where z is on a slice or beyond all.
    std::pair<const Level*, const Level*> around(double z) const {
        for (std::size_t k = 0; k + 1 < levels_.size(); ++k) {
            if (z > levels_[k].z + 1e-6 && z < levels_[k + 1].z - 1e-6) return {&levels_[k], &levels_[k + 1]};
        }
        return {nullptr, nullptr};
    }

  private:
    static constexpr double reach = 20;  // mm
    Plane frame_;
    std::vector<Level> levels_;
};

Result<ContourSet> read(InputOptions options, RunContext& context) {
    ANATOMESH_TRY(OpenedInput opened, open_input(options, context));
    ANATOMESH_TRY(InputContours contours, contours_of(std::move(opened), options, context));
    return std::move(contours.kept);
}

// Pixels round all that is drawn near: on a lattice through the frame's origin, that of the pixels of an
// image.
std::optional<PixelGrid> grid_round(const Box2& box, double pixel) {
    if (box.empty()) return std::nullopt;
    const double x0 = std::floor(box.low.x / pixel) - 3, y0 = std::floor(box.low.y / pixel) - 3;
    return PixelGrid{{x0 * pixel, y0 * pixel},
                     {pixel, pixel},
                     static_cast<std::uint32_t>(std::ceil(box.high.x / pixel) + 4 - x0),
                     static_cast<std::uint32_t>(std::ceil(box.high.y / pixel) + 4 - y0)};
}

template <class Inside>
Mask sample(const PixelGrid& grid, Inside inside) {
    Mask mask(grid);
    for (std::uint32_t y = 1; y + 1 < grid.ny; ++y) {
        for (std::uint32_t x = 1; x + 1 < grid.nx; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * grid.nx + x;
            mask.inside[i] = inside(mask.point(i));
        }
    }
    return mask;
}

struct Scores {
    Score ours, nearest, shape_based;
};

// One structure on one left-out slice at height z.
void compare(const KeptSlices& kept, const StructureField& field, std::uint32_t structure, double z,
             const SliceRegion* truth_region, double pixel, Scores& scores) {
    const auto [below, above] = kept.around(z);
    // Ends are the caps' business.
    if (below == nullptr || !below->maps[structure] || !above->maps[structure]) return;
    Box2 box;
    if (truth_region != nullptr) {
        for (const Edge2& edge : truth_region->edges) box.extend(edge.a);
    }
    for (const KeptSlices::Level* level : {below, above}) {
        box.extend(level->maps[structure]->region_box().low);
        box.extend(level->maps[structure]->region_box().high);
    }
    const std::optional<PixelGrid> grid = grid_round(box, pixel);
    if (!grid) return;
    Mask truth(*grid);
    if (truth_region != nullptr) {
        fill_even_odd(truth_region->edges, *grid,
                      [&](std::uint32_t row, std::uint32_t first, std::uint32_t last) {
                          const auto begin =
                              truth.inside.begin() + static_cast<std::ptrdiff_t>(std::size_t{row} * grid->nx);
                          std::fill(begin + first, begin + last, std::uint8_t{1});
                      });
    }
    const double t = (z - below->z) / (above->z - below->z);
    scores.ours.add(sample(*grid,
                           [&](Vec2 q) {
                               const Vec3 p = kept.frame().to_space(q) + z * kept.frame().normal;
                               return field.value(structure, p) < 0;
                           }),
                    truth);
    const KeptSlices::Level& near = t <= 0.5 ? *below : *above;
    scores.nearest.add(sample(*grid, [&](Vec2 q) { return near.distance(structure, q) < 0; }), truth);
    scores.shape_based.add(
        sample(*grid,
               [&](Vec2 q) {
                   return (1 - t) * below->distance(structure, q) + t * above->distance(structure, q) < 0;
               }),
        truth);
}

Status run(const InputOptions& options, double pixel, RunContext& context) {
    InputOptions whole = options;
    whole.prepare.choice.every.reset();
    ANATOMESH_TRY(const ContourSet all, read(whole, context));
    ANATOMESH_TRY(const ContourSet kept_set, read(options, context));
    ANATOMESH_TRY(const auto field, make_structure_field(kept_set, {}, context));
    const KeptSlices kept(kept_set);
    if (pixel <= 0) pixel = kept_set.pixel_mm > 0 ? kept_set.pixel_mm : 1;
    Scores scores;
    for (std::uint32_t slice = 0; slice < all.slices.size(); ++slice) {
        const double z = kept.frame().signed_distance(all.slices[slice].plane.origin);
        const std::vector<SliceRegion> regions = slice_regions(all, slice, kept.frame());
        for (std::uint32_t s = 0; s < kept_set.structures.size(); ++s) {
            const auto found = std::find_if(regions.begin(), regions.end(), [&](const SliceRegion& region) {
                return all.structures[region.structure].number == kept_set.structures[s].number;
            });
            compare(kept, *field, s, z, found == regions.end() ? nullptr : &*found, pixel, scores);
        }
    }
    fmt::print("| {} | {} | {:.2f} | {} | {} | {} | {} |\n",
               std::filesystem::path(options.input).filename().string(),
               options.prepare.choice.every.value_or(1), field->slice_spacing(), scores.ours.sections(),
               scores.nearest.text(), scores.shape_based.text(), scores.ours.text());
    return Nothing{};
}

int report(const Status& done) {
    if (!done.ok()) fmt::print(stderr, "{}\n", to_line(done.error()));
    return done.ok() ? 0 : 1;
}

}  // namespace
}  // namespace anatomesh

int main(int argc, char** argv) {
    using namespace anatomesh;
    CLI::App app("Left-out slices predicted: nearest slice, shape-based interpolation, ours");
    InputOptions options;
    double pixel = 0;
    bool header = false;
    app.add_option("--pixel", pixel, "Pixels to compare on, mm; 0: those of the image, else 1");
    app.add_flag("--header", header, "Print the head of the table first");
    CutOptions cut;
    app.add_option("--cut", cut.kind,
                   "Cut the input by planes and compare with it: fan, axis, stacks or freehand")
        ->check(CLI::IsMember({"fan", "axis", "stacks", "freehand"}));
    app.add_option("--planes", cut.planes, "With --cut: how many")->check(CLI::Range(3u, 10000u));
    app.add_option("--points", cut.spacing_mm, "With --cut: distance of the points on a contour, mm");
    std::uint32_t leave_out = 0;
    app.add_option(
           "--leave-out", leave_out,
           "Leave out every N-th plane, of planes in any position, and compare with what is drawn on it")
        ->check(CLI::Range(2u, 1000u));
    options.prepare.until = PrepareUntil::walls;
    add_reconcile_options(app, options);
    add_reading_options(app, options);
    add_selection_options(app, options);
    CLI11_PARSE(app, argc, argv);
    if (!cut.kind.empty()) return report(cut_planes(options, cut, header));
    if (leave_out > 0) return report(leave_out_planes(options, leave_out, header));
    if (options.prepare.choice.every.value_or(1) < 2) {
        fmt::print(stderr, "--every must be 2 or more\n");
        return 2;
    }
    if (header) {
        fmt::print(
            "| input | every | spacing, mm | sections | nearest: Dice | mm | shape-based: Dice | mm | ours: "
            "Dice | "
            "mm |\n|---|---|---|---|---|---|---|---|---|---|\n");
    }
    RunContext context;
    return report(run(options, pixel, context));
}
