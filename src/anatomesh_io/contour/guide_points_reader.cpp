#include "anatomesh_io/contour/guide_points_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

constexpr std::string_view start_of_table = "x\ty\tz\tcontour type\t";
// A curve with more guide points is refused, because the search for their order takes time by the square of
// their number. [points; >= 1; B]
constexpr std::size_t most_points = 5000;
// An outline whose ends are no further apart than so many median steps is closed: its last points were left
// out. [median steps; > 1; M 2026-11 hearts]
constexpr double most_steps = 4;

using Points = std::vector<Vec3>;

struct Curve {
    std::vector<std::uint32_t> order;
    double longest_step = 0, median_step = 0;
    double gap = 0;  // from its end to its start

    double widest() const { return std::max(longest_step, gap); }
};

// Parents in the minimum spanning tree, the root its own.
std::vector<std::uint32_t> spanning_tree(const Points& points) {
    const auto count = static_cast<std::uint32_t>(points.size());
    std::vector<std::uint32_t> parent(count, 0);
    std::vector<double> distance(count, std::numeric_limits<double>::infinity());
    std::vector<bool> is_in(count, false);
    for (std::uint32_t at = 0, done = 0; done < count; ++done) {
        is_in[at] = true;
        std::uint32_t next = at;
        double nearest = std::numeric_limits<double>::infinity();
        for (std::uint32_t p = 0; p < count; ++p) {
            if (is_in[p]) continue;
            const double d = length(points[p] - points[at]);
            if (d < distance[p]) {
                distance[p] = d;
                parent[p] = at;
            }
            if (distance[p] < nearest) {
                nearest = distance[p];
                next = p;
            }
        }
        at = next;
    }
    return parent;
}

// The point farthest from `from` along the tree, and the way there by `came_from`.
std::uint32_t farthest(const Points& points, const std::vector<std::vector<std::uint32_t>>& neighbors,
                       std::uint32_t from, std::vector<std::uint32_t>& came_from) {
    std::vector<double> way(points.size(), -1);
    std::vector<std::uint32_t> open{from};
    way[from] = 0;
    came_from.assign(points.size(), from);
    std::uint32_t best = from;
    while (!open.empty()) {
        const std::uint32_t at = open.back();
        open.pop_back();
        if (way[at] > way[best]) best = at;
        for (const std::uint32_t next : neighbors[at]) {
            if (way[next] >= 0) continue;
            way[next] = way[at] + length(points[next] - points[at]);
            came_from[next] = at;
            open.push_back(next);
        }
    }
    return best;
}

// The longest way through the minimum spanning tree.
Curve curve_of(const Points& points) {
    const std::vector<std::uint32_t> parent = spanning_tree(points);
    std::vector<std::vector<std::uint32_t>> neighbors(points.size());
    for (std::uint32_t p = 1; p < points.size(); ++p) {
        neighbors[p].push_back(parent[p]);
        neighbors[parent[p]].push_back(p);
    }
    std::vector<std::uint32_t> came_from;
    const std::uint32_t one = farthest(points, neighbors, 0, came_from);
    std::uint32_t at = farthest(points, neighbors, one, came_from);
    Curve curve;
    curve.order = {at};
    std::vector<double> steps;
    while (at != one) {
        steps.push_back(length(points[came_from[at]] - points[at]));
        at = came_from[at];
        curve.order.push_back(at);
    }
    if (steps.empty()) return curve;
    curve.gap = length(points[curve.order.front()] - points[curve.order.back()]);
    curve.longest_step = *std::max_element(steps.begin(), steps.end());
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    curve.median_step = *middle;
    return curve;
}

class GuidePointsReader {
  public:
    GuidePointsReader(std::string_view text, std::optional<std::uint64_t> time_frame, RawBuilder& builder)
        : text_(text), time_frame_(time_frame), builder_(builder) {}

    Status read() {
        builder_.frame = FileFrame::lps;
        ANATOMESH_CHECK_STATUS(read_lines());
        ANATOMESH_CHECK_STATUS(check_time_frame());
        std::set<std::string> names;
        for (const auto& [key, points] : curves_) names.insert(key.surface);
        std::map<std::string, std::uint32_t> structure_of;
        for (const std::string& name : names) {
            Structure structure;
            structure.name = name;
            structure.number = static_cast<std::int32_t>(structure_of.size()) + 1;
            ANATOMESH_TRY(structure_of[name], builder_.add_structure(std::move(structure)));
        }
        for (const auto& [key, curve] : curves_) {
            if (builder_.context().cancelled()) return cancelled_error();
            ANATOMESH_CHECK_STATUS(add(key, curve, structure_of[key.surface]));
        }
        if (left_out_ > 0)
            builder_.context().warn({"W-GPT-001",
                                     std::to_string(left_out_) + " guide points do not lie on their curve",
                                     {builder_.file(), {}, {}, {}, {}},
                                     "they were left out"});
        if (unused_ > 0)
            builder_.context().warn(
                {"W-GPT-002",
                 std::to_string(unused_) +
                     " points of the septum do not close a gap in the outline of the left ventricle",
                 {builder_.file(), {}, {}, {}, {}},
                 "they were not used"});
        return Nothing{};
    }

  private:
    struct Key {
        std::string surface, slice;
        friend auto operator<=>(const Key&, const Key&) = default;
    };
    struct Collected {
        std::set<std::array<double, 3>> points, lent;  // each once; those of a part of two surfaces
        bool is_short_axis = false, is_long_axis = false, is_marker = false;
        bool has_outline = false, has_wall = false, has_septum = false;  // of points
    };

    Status read_lines() {
        std::size_t number = 0;
        while (!text_.empty()) {
            const std::size_t end = std::min(text_.find('\n'), text_.size());
            std::string_view line = text_.substr(0, end);
            text_.remove_prefix(std::min(end + 1, text_.size()));
            if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
            if (number++ == 0 || line.empty()) continue;  // the names of the columns
            ANATOMESH_CHECK_STATUS(read_line(line, number));
        }
        return Nothing{};
    }

    Status read_line(std::string_view line, std::size_t number) {
        std::array<std::string_view, 7> fields;
        for (std::size_t f = 0; f < fields.size(); ++f) {
            const std::size_t end = std::min(line.find('\t'), line.size());
            if ((end == line.size()) != (f + 1 == fields.size()))
                return failure("E-GPT-001", "a line does not have seven fields", number, line);
            fields[f] = line.substr(0, end);
            line.remove_prefix(std::min(end + 1, line.size()));
        }
        std::array<double, 3> point{};
        for (std::size_t c = 0; c < 3; ++c) {
            const auto value = parse_number(fields[c]);
            if (!value) return failure("E-GPT-002", "a coordinate is not a number", number, fields[c]);
            point[c] = *value;
        }
        const auto time = parse_integer<std::uint64_t>(fields[6].substr(0, fields[6].find('.')));
        if (!time) return failure("E-GPT-002", "the time frame is not a whole number", number, fields[6]);
        ++times_[*time];
        if (time_frame_ && *time != *time_frame_) return Nothing{};
        return collect(std::string(fields[3]), std::string(fields[4]), point, number);
    }

    Status collect(const std::string& type, const std::string& slice, const std::array<double, 3>& point,
                   std::size_t line) {
        const bool is_short_axis = type.starts_with("SAX_"), is_long_axis = type.starts_with("LAX_"),
                   has_view = is_short_axis || is_long_axis;
        const bool is_marker =
            type.ends_with("_VALVE") || type.ends_with("_POINT") || type.ends_with("_INSERT");
        std::vector<std::string> surfaces{has_view ? type.substr(4) : type};
        const bool is_wall = surfaces[0] == "RV_FREEWALL";
        if (is_wall) surfaces = {"RV_ENDOCARDIAL"};
        const bool is_septum = surfaces[0] == "RV_SEPTUM";
        if (is_septum) surfaces = {"RV_ENDOCARDIAL", "LV_EPICARDIAL"};
        if (type.ends_with("_VALVE")) valves_[slice].push_back({point[0], point[1], point[2]});
        for (const std::string& surface : surfaces) {
            Collected& curve = curves_[{surface, slice}];
            (is_septum && surface == surfaces[1] ? curve.lent : curve.points).insert(point);
            curve.has_wall = curve.has_wall || is_wall;
            curve.has_septum = curve.has_septum || is_septum;
            curve.has_outline = curve.has_outline || !(is_wall || is_septum);
            curve.is_short_axis = curve.is_short_axis || is_short_axis;
            curve.is_long_axis = curve.is_long_axis || is_long_axis;
            curve.is_marker = is_marker;
            if (curve.points.size() + curve.lent.size() > most_points) {
                Error error =
                    failure("E-GPT-004", "a surface has more than 5000 points in one slice", line, surface);
                error.kind = ErrorKind::limit;
                return error;
            }
        }
        return Nothing{};
    }

    Status check_time_frame() const {
        const bool is_there = !time_frame_ || times_.contains(*time_frame_);
        if (is_there && (time_frame_ || times_.size() < 2)) return Nothing{};
        std::string list;
        for (const auto& [time, points] : times_) {
            if (list.size() > 60) {
                list += " ... " + std::to_string(times_.rbegin()->first);
                break;
            }
            list += (list.empty() ? "" : ", ") + std::to_string(time) + " (" + std::to_string(points) +
                    (points == 1 ? " point)" : " points)");
        }
        return Error{ErrorKind::input,
                     "E-GPT-003",
                     is_there ? "the file holds guide points of several time frames"
                              : "the file holds no guide points of this time frame",
                     {builder_.file(), {}, {}, {}, list},
                     "choose one with --volume N"};
    }

    // The points of a surface in a slice; with those of the part that another one lends where they fill a gap
    // in its outline. Where that is closed, or the part is far from it, they belong to another wall.
    Points points_of(const Collected& collected) {
        Points own, all;
        for (const auto& [x, y, z] : collected.points) own.push_back({x, y, z});
        if (collected.lent.empty()) return own;
        std::set<std::array<double, 3>> both = collected.points;
        both.insert(collected.lent.begin(), collected.lent.end());
        for (const auto& [x, y, z] : both) all.push_back({x, y, z});
        if (own.size() < 3 || curve_of(all).widest() < curve_of(own).widest()) return all;
        unused_ += all.size() - own.size();
        return own;
    }

    // Whether the ends of a long-axis contour lie at a valve: nearer to one of its slice than half way to
    // each other. Where the slice has none marked, it is not known better.
    bool ends_at_valve(const std::string& slice, const Points& points, const Curve& curve) const {
        const auto valves = valves_.find(slice);
        if (valves == valves_.end()) return true;
        for (const std::uint32_t end : {curve.order.front(), curve.order.back()}) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const Vec3& valve : valves->second) nearest = std::min(nearest, length(points[end] - valve));
            if (nearest > 0.5 * curve.gap) return false;
        }
        return true;
    }

    ContourKind kind_of(const Key& key, const Collected& collected, const Points& points,
                        const Curve& curve) const {
        if (curve.order.size() < 3) return ContourKind::open;
        const bool has_part = collected.has_outline || collected.has_wall,
                   is_whole = collected.has_outline || (collected.has_wall && collected.has_septum);
        if (collected.is_short_axis && has_part) return ContourKind::closed_planar;
        if (has_part && curve.gap <= most_steps * curve.median_step) return ContourKind::closed_planar;
        return collected.is_long_axis && is_whole && ends_at_valve(key.slice, points, curve)
                   ? ContourKind::open_at_valve
                   : ContourKind::open;
    }

    Status add(const Key& key, const Collected& collected, std::uint32_t structure) {
        const Points points = points_of(collected);
        std::vector<std::uint32_t> order(points.size());
        for (std::uint32_t p = 0; p < points.size(); ++p) order[p] = p;
        ContourKind kind = ContourKind::point;
        if (!collected.is_marker && points.size() > 2) {
            Curve curve = curve_of(points);
            left_out_ += points.size() - curve.order.size();
            kind = kind_of(key, collected, points, curve);
            order = std::move(curve.order);
        }
        ANATOMESH_CHECK_STATUS(builder_.begin_contour(structure, kind, -1, "slice " + key.slice, key.slice));
        for (const std::uint32_t p : order) {
            ANATOMESH_CHECK_STATUS(builder_.add_point(points[p]));
        }
        return Nothing{};
    }

    Error failure(const char* code, const char* message, std::size_t line, std::string_view value) const {
        bool changed = false;
        return {ErrorKind::input,
                code,
                message,
                {builder_.file(), "line " + std::to_string(line), {}, {}, valid_utf8(shown(value), changed)},
                "correct the table"};
    }

    std::string_view text_;
    std::optional<std::uint64_t> time_frame_;
    RawBuilder& builder_;
    std::map<Key, Collected> curves_;
    std::map<std::uint64_t, std::uint64_t> times_;  // and how many points
    std::map<std::string, Points> valves_;          // by slice
    std::uint64_t left_out_ = 0, unused_ = 0;
};

}  // namespace

bool is_guide_points(std::string_view text) {
    return text.starts_with(start_of_table);
}

Status read_guide_points(std::string_view text, std::optional<std::uint64_t> time_frame,
                         RawBuilder& builder) {
    return GuidePointsReader(text, time_frame, builder).read();
}

}  // namespace anatomesh
