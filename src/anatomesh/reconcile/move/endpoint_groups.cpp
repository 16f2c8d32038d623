#include "anatomesh/reconcile/move/endpoint_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "anatomesh/base/sort_distinct.h"

namespace anatomesh {

namespace {

// Ends that lie no further apart across their direction are one point already.
// [mm; 0 to joinable_mm; D rounding of doubles]
constexpr double same_point_mm = 1e-6;
// Places of contours along their line get this weight, so that no sum of weights is 0. [1; > 0; D]
constexpr double least_weight = 1e-6;
// A smaller determinant, per line cubed, is that of lines nearly parallel to each other. [1; > 0; D]
constexpr double least_determinant = 1e-6;

// A place and a line that it has to stay on.
struct Membership {
    std::uint32_t root = 0, place = 0;
    const Line* line = nullptr;
    const IntervalEndpoint* end = nullptr;
};

std::uint32_t find_root(std::vector<std::uint32_t>& parent, std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

// Returns every matched endpoint with its line, by group, in order of places.
std::vector<Membership> memberships(const EndpointPlaces& ends, std::span<const LineComparison> comparisons) {
    std::vector<std::uint32_t> parent(ends.places.size());
    std::iota(parent.begin(), parent.end(), 0u);
    std::vector<Membership> members;
    for (std::size_t c = 0; c < comparisons.size(); ++c) {
        const LineComparison& comparison = comparisons[c];
        for (const auto& [i, j] : comparison.matching.matched) {
            const std::uint32_t p = ends.of_a[c][i], q = ends.of_b[c][j];
            members.push_back({0, p, &comparison.line, &comparison.endpoints_a[i]});
            members.push_back({0, q, &comparison.line, &comparison.endpoints_b[j]});
            const std::uint32_t root_p = find_root(parent, p), root_q = find_root(parent, q);
            parent[std::max(root_p, root_q)] = std::min(root_p, root_q);
        }
    }
    for (Membership& member : members) member.root = find_root(parent, member.place);
    std::stable_sort(members.begin(), members.end(), [](const Membership& p, const Membership& q) {
        return std::tie(p.root, p.place) < std::tie(q.root, q.place);
    });
    return members;
}

bool same_line(const Line& p, const Line& q) {
    if (squared_length(cross(p.direction, q.direction)) > 1e-16) return false;
    const Vec3 offset = q.origin - p.origin;
    return length(offset - dot(offset, p.direction) * p.direction) <= same_point_mm;
}

class EndpointGrouping {
  public:
    EndpointGrouping(const ContourSet& set, const EndpointPlaces& ends, EndpointGroups& groups)
        : set_(set), ends_(ends), groups_(groups) {}

    void add(std::span<const Membership> members) {
        const auto group = static_cast<std::uint32_t>(groups_.position.size());
        const Line& line = *members.front().line;
        for (const Membership& member : members) {
            EndpointGroups::Member& place = groups_.members[member.place];
            if (place.group != no_node) continue;
            place.group = group;
            const Plane& plane = set_.slices[set_.contours[member.end->contour].slice].plane;
            const Vec2 normal = contour_normal(set_, *member.end, moving_chord_mm);
            place.sine = dot(normal, {dot(line.direction, plane.u), dot(line.direction, plane.v)});
            place.direction = place.sine * normal;
            place.sine = std::abs(place.sine);
            place.place = line.along(member.end->at);
        }
        const bool one_line = std::all_of(members.begin(), members.end(), [&](const Membership& member) {
            return same_line(line, *member.line);
        });
        std::vector<Line> lines;
        for (const Membership& member : members) lines.push_back(*member.line);
        Vec3 target;
        if (one_line || !meeting_point(lines, members.front().end->at, target)) {
            target = mean_on(line, members);
            groups_.position.push_back(line.along(target));
            measure(members, target);
        } else {
            groups_.position.push_back(0);
            pin(members, target);
        }
        groups_.target.push_back(target);
        groups_.lines.emplace_back();
        add_lines(lines, groups_.lines.back());
        std::vector<std::uint32_t> slices, contours;
        for (const Membership& member : members) {
            slices.push_back(set_.contours[member.end->contour].slice);
            contours.push_back(member.end->contour);
        }
        sort_distinct(slices);
        sort_distinct(contours);
        groups_.slices.push_back(std::move(slices));
        groups_.contours.push_back(std::move(contours));
    }

  private:
    Vec3 mean_on(const Line& line, std::span<const Membership> members) const {
        double sum = 0, weights = 0;
        for (const Membership& member : members) {
            const EndpointGroups::Member& place = groups_.members[member.place];
            const double weight = place.weight();
            sum += weight * place.place;
            weights += weight;
        }
        const double position = sum / weights;
        double spread = 0;
        for (const Membership& member : members) {
            spread = std::max(spread, std::abs(groups_.members[member.place].place - position));
        }
        for (const Membership& member : members) {
            const Vec3 at = ends_.places[member.place].at;
            const bool drawn = ends_.places[member.place].node != no_node && spread <= same_point_mm;
            if (drawn && length(at - line.at(line.along(at))) <= line_in_plane_mm) return at;
        }
        return line.at(position);
    }

    void measure(std::span<const Membership> members, Vec3 target) {
        for (const Membership& member : members) {
            const double distance = length(target - ends_.places[member.place].at);
            groups_.worst_mm = std::max(groups_.worst_mm, distance * groups_.members[member.place].sine);
        }
    }

    void pin(std::span<const Membership> members, Vec3 target) {
        for (const Membership& member : members) {
            EndpointGroups::Member& place = groups_.members[member.place];
            const Plane& plane = set_.slices[set_.contours[member.end->contour].slice].plane;
            const Vec3 move = target - ends_.places[member.place].at;
            place.pinned = true;
            place.sine = 1;
            place.direction = {dot(move, plane.u), dot(move, plane.v)};
            groups_.worst_mm = std::max(groups_.worst_mm, length(place.direction));
        }
    }

    const ContourSet& set_;
    const EndpointPlaces& ends_;
    EndpointGroups& groups_;
};

}  // namespace

double EndpointGroups::Member::weight() const {
    return sine * sine + least_weight;
}

void add_lines(std::span<const Line> lines, std::vector<Line>& distinct) {
    for (const Line& line : lines) {
        const auto same = [&](const Line& other) { return same_line(line, other); };
        if (std::none_of(distinct.begin(), distinct.end(), same)) distinct.push_back(line);
    }
}

// Solves (sum of (1 - d d^T)) x = sum of (1 - d d^T) o by Cramer's rule.
bool meeting_point(std::span<const Line> lines, Vec3 near, Vec3& point) {
    Vec3 row_x, row_y, row_z, right;
    for (const Line& line : lines) {
        const Vec3 d = line.direction, o = line.origin - near;
        row_x += Vec3{1, 0, 0} - d.x * d;
        row_y += Vec3{0, 1, 0} - d.y * d;
        row_z += Vec3{0, 0, 1} - d.z * d;
        right += o - dot(o, d) * d;
    }
    const double determinant = dot(row_x, cross(row_y, row_z));
    const auto count = static_cast<double>(lines.size());
    if (!(determinant > least_determinant * count * count * count)) return false;
    // The matrix is symmetric: its rows are its columns.
    point = near + (1 / determinant) * Vec3{dot(right, cross(row_y, row_z)), dot(row_x, cross(right, row_z)),
                                            dot(row_x, cross(row_y, right))};
    return true;
}

EndpointGroups group_endpoints(const ContourSet& set, const EndpointPlaces& ends,
                               std::span<const LineComparison> comparisons) {
    EndpointGroups groups;
    groups.members.resize(ends.places.size());
    const std::vector<Membership> members = memberships(ends, comparisons);
    EndpointGrouping grouping(set, ends, groups);
    for (std::size_t begin = 0, end = 0; begin < members.size(); begin = end) {
        while (end < members.size() && members[end].root == members[begin].root) ++end;
        grouping.add({members.data() + begin, end - begin});
    }
    return groups;
}

}  // namespace anatomesh
