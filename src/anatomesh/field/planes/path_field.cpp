#include "anatomesh/field/planes/path_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/field/model/field_queries.h"
#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/field/warnings/sparse_planes.h"
#include "anatomesh/field/warnings/thin_structures.h"

namespace anatomesh {

namespace {

// Values reach as far as in a stack of the same spacing. [spacings; > 0; D parallel_field.cpp]
constexpr double clamp_spacings = 1.5;
// Gaps are looked up in a grid of so many cells a side at most. [cells; >= 1; B]
constexpr double most_cells = 64;
// Contours are held against other paths at points so far apart, at most. [spacings; 0 to 1; C]
constexpr double contour_step = 0.25;
// A path that ends less far before another tube of its structure may be a branch of it. [spacings; > 0.5; C]
constexpr double most_before_tube = 2;
// A contour that lies less deep in another path runs along its surface. [spacings; 0 to 0.1; C]
constexpr double least_depth = 1e-3;
// A message names no more slices, so that it stays one line. [slices; >= 1; B]
constexpr std::size_t most_named = 5;

// Which boxes hold a point: a grid whose cells list the boxes that meet them. Immutable.
class BoxGrid {
  public:
    BoxGrid() = default;
    // Complexity: O(cells that boxes meet).
    explicit BoxGrid(std::vector<Box3> boxes) : boxes_(std::move(boxes)) {
        for (const Box3& box : boxes_) {
            all_.extend(box.low);
            all_.extend(box.high);
        }
        const Vec3 size = all_.high - all_.low;
        inverse_cell_ = most_cells / std::max({size.x, size.y, size.z, 1e-9});
        cells_ = {count_of(size.x), count_of(size.y), count_of(size.z)};
        std::vector<std::vector<std::uint32_t>> lists(std::size_t{cells_[0]} * cells_[1] * cells_[2]);
        for (std::uint32_t n = 0; n < boxes_.size(); ++n) {
            const auto low = cell_at(boxes_[n].low), high = cell_at(boxes_[n].high);
            for (std::uint32_t z = low[2]; z <= high[2]; ++z)
                for (std::uint32_t y = low[1]; y <= high[1]; ++y)
                    for (std::uint32_t x = low[0]; x <= high[0]; ++x) lists[index_of({x, y, z})].push_back(n);
        }
        begin_.assign(1, 0);
        for (const auto& list : lists) {
            listed_.insert(listed_.end(), list.begin(), list.end());
            begin_.push_back(static_cast<std::uint32_t>(listed_.size()));
        }
    }

    const Box3& box(std::uint32_t n) const { return boxes_[n]; }

    // Of the boxes that may hold p, rising.
    std::span<const std::uint32_t> near(Vec3 p) const {
        if (!all_.contains(p)) return {};
        const std::size_t cell = index_of(cell_at(p));
        return {listed_.data() + begin_[cell], begin_[cell + 1] - begin_[cell]};
    }

  private:
    std::uint32_t count_of(double size) const {
        return static_cast<std::uint32_t>(std::clamp(std::ceil(size * inverse_cell_), 1.0, most_cells));
    }
    std::array<std::uint32_t, 3> cell_at(Vec3 p) const {
        const Vec3 at = inverse_cell_ * (p - all_.low);
        const auto cell = [](double x, std::uint32_t count) {
            return static_cast<std::uint32_t>(std::clamp(x, 0.0, static_cast<double>(count - 1)));
        };
        return {cell(at.x, cells_[0]), cell(at.y, cells_[1]), cell(at.z, cells_[2])};
    }
    std::size_t index_of(const std::array<std::uint32_t, 3>& cell) const {
        return (std::size_t{cell[2]} * cells_[1] + cell[1]) * cells_[0] + cell[0];
    }

    std::vector<Box3> boxes_;
    Box3 all_;
    double inverse_cell_ = 0;
    std::array<std::uint32_t, 3> cells_{1, 1, 1};
    std::vector<std::uint32_t> begin_, listed_;
};

class PathField final : public FieldQueries<PathField> {
  public:
    using Fields = std::vector<std::shared_ptr<const StructureField>>;

    // `in_charts`: of each path.
    PathField(std::vector<SlicePath> paths, Fields in_charts, const ContourSet& set)
        : paths_(std::move(paths)), in_charts_(std::move(in_charts)), boxes_(set.structures.size()) {
        clamp_ = in_charts_.front()->clamp();
        std::vector<double> spacings;
        std::vector<Box3> boxes;
        for (std::uint32_t n = 0; n < paths_.size(); ++n) {
            const SlicePath& path = paths_[n];
            spacings.push_back(in_charts_[n]->slice_spacing());
            const Box3 charted = path.to_chart(set).box(), reached = in_charts_[n]->box();
            const Vec3 low = charted.low - reached.low, high = reached.high - charted.high;
            const double reach = std::max({low.x, low.y, low.z, high.x, high.y, high.z, 0.0});
            Box3 whole;  // of what is not outside
            for (std::uint32_t gap = 0; gap < path.gap_count(); ++gap) {
                gaps_.push_back({n, gap});
                boxes.push_back(path.box_of(gap, reach + clamp_));
                const Box3 inner = path.box_of(gap, reach);
                whole.extend(inner.low);
                whole.extend(inner.high);
            }
            box_.extend(whole.low);
            box_.extend(whole.high);
            for (const PathSlice& slice : path.slices()) {
                for (const std::uint32_t c : slice.contours) {
                    boxes_[set.contours[c].structure].extend(whole.low);
                    boxes_[set.contours[c].structure].extend(whole.high);
                }
            }
        }
        grid_ = BoxGrid(std::move(boxes));
        std::nth_element(spacings.begin(),
                         spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2), spacings.end());
        spacing_ = spacings[spacings.size() / 2];
    }

    double slice_spacing() const override { return spacing_; }
    std::vector<const StructureField*> parts() const override {
        std::vector<const StructureField*> parts;
        for (const auto& field : in_charts_) parts.push_back(field.get());
        return parts;
    }
    Box3 box() const override { return box_; }
    Box3 box_of(std::uint32_t structure) const override { return boxes_[structure]; }
    std::vector<Plane> flat_ends() const override {
        std::vector<Plane> ends;
        for (std::size_t n = 0; n < paths_.size(); ++n) {
            for (const Plane& end : in_charts_[n]->flat_ends())
                ends.push_back(paths_[n].slice_at(end.origin.z));
        }
        return ends;
    }

    // Of all paths but one.
    double value_beside(std::uint32_t path, std::uint32_t structure, Vec3 p) const {
        double least = clamp_;
        each_place(p, [&](const StructureField& field, Vec3 q) {
            if (&field != in_charts_[path].get()) least = std::min(least, field.value(structure, q));
        });
        return least;
    }

    // Of one path alone.
    double value_of(std::uint32_t path, std::uint32_t structure, Vec3 p) const {
        double least = clamp_;
        each_place(p, [&](const StructureField& field, Vec3 q) {
            if (&field == in_charts_[path].get()) least = std::min(least, field.value(structure, q));
        });
        return least;
    }

    static constexpr bool sides_cost_less = false;
    RawValue raw(std::uint32_t structure, Vec3 p, double reach) const {
        double least = clamp_;
        each_place(p, [&](const StructureField& field, Vec3 q) {
            least = std::min(least, field.value_within(structure, q, reach));
        });
        return {least};
    }
    double raw_union(Vec3 p, double /*reach*/) const {
        double least = clamp_;
        each_place(
            p, [&](const StructureField& field, Vec3 q) { least = std::min(least, field.union_value(q)); });
        return least;
    }
    template <class Body>
    void each_raw(Vec3 p, double /*reach*/, Body body) const {
        std::vector<Near> near;
        std::size_t places = 0;
        each_place(p, [&](const StructureField& field, Vec3 q) {
            field.values_near(q, near);
            ++places;
        });
        if (places > 1) {
            std::sort(near.begin(), near.end(), [](const Near& a, const Near& b) {
                return a.structure != b.structure ? a.structure < b.structure : a.value < b.value;
            });
        }
        for (std::size_t n = 0; n < near.size(); ++n) {
            if (n > 0 && near[n].structure == near[n - 1].structure) continue;
            if (near[n].value < clamp_) body(near[n].structure, RawValue{near[n].value});
        }
    }

  private:
    struct Gap {
        std::uint32_t path, gap;
    };

    // Calls body(field, chart coordinates) for the gaps that p lies in.
    template <class Body>
    void each_place(Vec3 p, Body body) const {
        for (const std::uint32_t n : grid_.near(p)) {
            if (!grid_.box(n).contains(p)) continue;
            const Gap& gap = gaps_[n];
            if (const std::optional<Vec3> q = paths_[gap.path].to_chart(gap.gap, p))
                body(*in_charts_[gap.path], *q);
        }
    }

    std::vector<SlicePath> paths_;
    Fields in_charts_;
    std::vector<Gap> gaps_;  // as in the grid
    BoxGrid grid_;
    Box3 box_;
    std::vector<Box3> boxes_;  // by structure; empty of one that is not drawn
    double spacing_ = 0;
};

// Where a path ends before another tube of its structure, so near that a slice more would lie in it: how far its end,
// half a spacing beyond the last slice, is from that tube; nothing elsewhere.
std::optional<double> gap_before_tube(const PathField& field, const SlicePath& path, std::uint32_t n,
                                      bool last, const ContourSet& set) {
    const std::size_t count = path.slices().size();
    const PathSlice &end = path.slices()[last ? count - 1 : 0], &next = path.slices()[last ? count - 2 : 1];
    const auto middle = [&](const PathSlice& slice) {
        const PlanePatch patch = patch_of(set, slice);
        return patch.plane.to_space(0.5 * (patch.box.low + patch.box.high));
    };
    const Vec3 from = middle(end), way = from - middle(next);
    const double spacing = length(way);
    const std::uint32_t structure = set.contours[end.contours.front()].structure;
    for (double along = 0; along <= most_before_tube; along += contour_step / 2) {
        if (!(field.value_beside(n, structure, from + along * way) < 0)) continue;
        return along > 0.5 ? std::optional((along - 0.5) * spacing) : std::nullopt;
    }
    return std::nullopt;
}

// The widest usual spacing of the paths.
double spacing_of(const std::vector<SlicePath>& paths) {
    double widest = 0;
    for (const SlicePath& path : paths) {
        std::vector<double> gaps;
        for (std::size_t n = 1; n < path.slices().size(); ++n)
            gaps.push_back(path.height(n) - path.height(n - 1));
        const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
        std::nth_element(gaps.begin(), middle, gaps.end());
        widest = std::max(widest, *middle);
    }
    return widest;
}

// By contour of the set, whether it lies on no path.
std::vector<std::uint8_t> marked_off_paths(const ContourSet& set, const std::vector<SlicePath>& paths) {
    std::vector<std::uint8_t> off(set.contours.size(), 1);
    for (const SlicePath& path : paths) {
        for (const PathSlice& slice : path.slices()) {
            for (const std::uint32_t c : slice.contours) off[c] = 0;
        }
    }
    return off;
}

// A contour on no path, and the gap of a path that it lies in: between the slices gap - 1 and gap.
struct SkippedContour {
    std::uint32_t contour = 0, path = 0;
    std::size_t gap = 1;
};

// Of each contour on no path the gap nearest to its middle, of the paths that draw its structure.
std::vector<SkippedContour> skipped_contours(const ContourSet& set, const std::vector<SlicePath>& paths) {
    const std::vector<std::uint8_t> off = marked_off_paths(set, paths);
    const auto middle_of = [&](const PathSlice& slice) {
        const PlanePatch patch = patch_of(set, slice);
        return patch.plane.to_space(0.5 * (patch.box.low + patch.box.high));
    };
    std::vector<SkippedContour> skipped;
    for (std::uint32_t c = 0; c < off.size(); ++c) {
        if (!off[c]) continue;
        const Contour& contour = set.contours[c];
        const Vec3 at = middle_of({contour.slice, {c}});
        SkippedContour found{c, 0, 1};
        double least = HUGE_VAL;
        for (std::uint32_t n = 0; n < paths.size(); ++n) {
            const auto slices = paths[n].slices();
            for (std::size_t gap = 1; gap < slices.size(); ++gap) {
                const auto draws = [&](std::uint32_t other) {
                    return set.contours[other].structure == contour.structure;
                };
                const std::vector<std::uint32_t>& below = slices[gap - 1].contours;
                if (std::none_of(below.begin(), below.end(), draws)) continue;
                const Vec3 from = middle_of(slices[gap - 1]), way = middle_of(slices[gap]) - from;
                const double along = std::clamp(dot(at - from, way) / squared_length(way), 0.0, 1.0);
                const double distance = squared_length(at - from - along * way);
                if (!(distance < least)) continue;
                least = distance;
                found.path = n;
                found.gap = gap;
            }
        }
        skipped.push_back(found);
    }
    return skipped;
}

// The path's chart of the set, in which a skipped slice is one that was left out: skipped ones part their gap evenly,
// so that it is as wide as those around it.
ContourSet charted(const ContourSet& set, const SlicePath& path, std::uint32_t number,
                   const std::vector<SkippedContour>& skipped) {
    ContourSet made = path.to_chart(set);
    std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> counts;  // by structure and gap
    for (const SkippedContour& one : skipped) {
        if (one.path == number) ++counts[{set.contours[one.contour].structure, one.gap}];
    }
    for (const auto& [where, count] : counts) {
        const double low = path.height(where.second - 1), high = path.height(where.second);
        for (std::size_t n = 1; n <= count; ++n) {
            const double z = low + static_cast<double>(n) / static_cast<double>(count + 1) * (high - low);
            made.left_out.push_back(
                {set.structures[where.first].number, {{0, 0, z}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
        }
    }
    return made;
}

Result<std::shared_ptr<const PathField>> field_along(const std::vector<SlicePath>& paths,
                                                     const ContourSet& set, FieldOptions options,
                                                     RunContext& context) {
    if (!(options.clamp_mm > 0)) options.clamp_mm = clamp_spacings * spacing_of(paths);
    options.knows_few_slices = false;
    const std::vector<SkippedContour> skipped = skipped_contours(set, paths);
    PathField::Fields in_charts;
    for (std::uint32_t n = 0; n < paths.size(); ++n) {
        ANATOMESH_TRY(std::shared_ptr<const StructureField> in_chart,
                      make_parallel_field(charted(set, paths[n], n, skipped), options, context));
        in_charts.push_back(std::move(in_chart));
    }
    return std::shared_ptr<const PathField>(std::make_shared<PathField>(paths, std::move(in_charts), set));
}

// Whether a part of a contour of a path lies inside what the others have of its structure.
bool is_inside_others(const PathField& field, std::uint32_t path, const ContourSet& set,
                      const Contour& contour) {
    const std::span<const Vec3> points = set.points_of(contour);
    const double depth = least_depth * field.slice_spacing(), step = contour_step * field.slice_spacing();
    for (std::size_t n = 0; n < points.size(); ++n) {
        const Vec3 from = points[n], way = points[n + 1 < points.size() ? n + 1 : 0] - from;
        const double parts = std::max(1.0, std::ceil(length(way) / step));
        for (double k = 0; k < parts; ++k) {
            if (field.value_beside(path, contour.structure, from + (k / parts) * way) < -depth) return true;
        }
    }
    return false;
}

// Whether contours of a path lie inside other tubes of their structure, or contours of these in it.
bool meets_others(const PathField& field, const std::vector<SlicePath>& paths, std::uint32_t n,
                  const ContourSet& set) {
    const auto is_inside = [&](std::uint32_t path, const Contour& contour) {
        const std::span<const Vec3> points = set.points_of(contour);
        return std::any_of(points.begin(), points.end(), [&](const Vec3& p) {
            return (path == n ? field.value_beside(n, contour.structure, p)
                              : field.value_of(n, contour.structure, p)) < 0;
        });
    };
    for (std::uint32_t path = 0; path < paths.size(); ++path) {
        for (const PathSlice& slice : paths[path].slices()) {
            for (const std::uint32_t c : slice.contours) {
                if (is_inside(path, set.contours[c])) return true;
            }
        }
    }
    return false;
}

void warn_about_branches_apart(const PathField& field, const std::vector<SlicePath>& paths,
                               const ContourSet& set, RunContext& context) {
    for (std::uint32_t n = 0; n < paths.size(); ++n) {
        for (const bool last : {false, true}) {
            const std::optional<double> gap = gap_before_tube(field, paths[n], n, last, set);
            if (!gap || meets_others(field, paths, n, set)) continue;
            const PathSlice& end = last ? paths[n].slices().back() : paths[n].slices().front();
            const Structure& structure = set.structures[set.contours[end.contours.front()].structure];
            context.warn(
                {"W-FLD-017",
                 "a tube ends shortly before another one of its structure, so that it may be a branch of it",
                 {set.source, set.slices[end.slice].name,
                  structure.name.empty() ? std::to_string(structure.number) : structure.name, "",
                  brief(*gap) + " mm apart"},
                 "they were not joined; draw the branch up to where it lies in the other tube"});
        }
    }
}

void warn_about_skipped_slices(const ContourSet& set, const std::vector<SlicePath>& paths,
                               RunContext& context) {
    const std::vector<std::uint8_t> off = marked_off_paths(set, paths);
    std::vector<std::uint32_t> slices;
    for (std::uint32_t c = 0; c < off.size(); ++c) {
        if (off[c] && (slices.empty() || slices.back() != set.contours[c].slice))
            slices.push_back(set.contours[c].slice);
    }
    if (slices.empty()) return;
    std::string names;
    for (std::size_t n = 0; n < std::min(slices.size(), most_named); ++n)
        names += (n > 0 ? ", " : "") + set.slices[slices[n]].name;
    if (slices.size() > most_named) names += ", ...";
    const auto first = std::find(off.begin(), off.end(), 1);
    const Structure& structure =
        set.structures[set.contours[static_cast<std::size_t>(first - off.begin())].structure];
    context.warn(
        {"W-FLD-019",
         "slices that follow the path of a tube lean so much that they cross others beside them: " + names,
         {set.source, set.slices[slices.front()].name,
          structure.name.empty() ? std::to_string(structure.number) : structure.name, "",
          std::to_string(slices.size()) + " of " + std::to_string(set.slices.size()) + " slices"},
         "the tube is shaped by the other slices, and its surface does not follow these; check their "
         "planes"});
}

}  // namespace

Result<std::shared_ptr<const StructureField>> make_path_field(const ContourSet& set, const SliceFacts& slices,
                                                              const FieldOptions& options,
                                                              RunContext& context) {
    const std::vector<SlicePath>& paths = slices.arrangement.paths;
    ANATOMESH_TRY(const std::shared_ptr<const PathField> field, field_along(paths, set, options, context));
    // What lies between two slices of a path they tell, unless the tube is thinner than half of the way.
    std::vector<double> known = mean_thicknesses(set);
    for (double& one : known) one = std::min(one, 0.5 * spacing_of(paths));
    warn_about_sparse_planes(set, *field, known, context);
    warn_about_branches_apart(*field, paths, set, context);
    warn_about_skipped_slices(set, paths, context);
    return std::shared_ptr<const StructureField>(field);
}

std::vector<std::uint8_t> contours_off_paths(const ContourSet& set, const SliceFacts& slices) {
    return marked_off_paths(set, slices.arrangement.paths);
}

Result<std::vector<std::uint8_t>> contours_inside_other_paths(const ContourSet& set, const SliceFacts& slices,
                                                              const FieldOptions& options,
                                                              RunContext& context) {
    const std::vector<SlicePath>& paths = slices.arrangement.paths;
    std::vector<std::uint8_t> inside(set.contours.size(), 0);
    if (paths.size() < 2) return inside;
    RunContext silent;  // the field itself tells what is amiss
    silent.threads = context.threads;
    ANATOMESH_TRY(const std::shared_ptr<const PathField> field, field_along(paths, set, options, silent));
    for (std::uint32_t n = 0; n < paths.size() && !context.cancelled(); ++n) {
        for (const PathSlice& slice : paths[n].slices()) {
            for (const std::uint32_t c : slice.contours)
                inside[c] = is_inside_others(*field, n, set, set.contours[c]);
        }
    }
    if (context.cancelled()) return cancelled_error();
    return inside;
}

}  // namespace anatomesh
