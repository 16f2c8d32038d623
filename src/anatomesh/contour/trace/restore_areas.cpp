#include "anatomesh/contour/trace/restore_areas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "anatomesh/contour/simplify/segment_grid.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// No point moves further, nor than the bound within which points were left out: the outline of a single pixel needs
// 0.21. [pixels; > 0; C]
constexpr double least_reach = 0.3;
// Within this bound a boundary passes no pixel centre, from which the traced one keeps away by 1/sqrt(8). [pixels; 0 to 0.35; D]
constexpr double clear_of_centres = 0.35;
// Of the distance between two things that both move, each may use this share. [1; 0 to 0.5; D they never meet]
constexpr double share_of_gap = 0.45;
// Of the distance to a pixel centre, which does not move. [1; 0 to 1; D they never meet]
constexpr double share_to_centre = 0.9;
// Nearer things do not move, since rounding could make them meet. [pixels; > 0; D far above rounding]
constexpr double least_gap = 1e-6;
// An area this near to that of its pixels is reached. [1; > 0; D a little above rounding]
constexpr double area_tolerance = 1e-12;
// A point that comes to its limit gets so much stiffer, and others give way instead. [1; > 1; M 2026-11 set]
constexpr double stiffening = 8;
// A round or a pass that leaves more than this of what is lacking is the last one. [1; 0 to 1; M 2026-11 set]
constexpr double little_progress = 0.9;
// Between two sets of limits there are at most so many rounds. [rounds; > 0; B]
constexpr int most_rounds = 16;
// As things move apart there is more room: limits are set anew at most so often. [passes; > 0; B]
constexpr int most_passes = 8;
// Conjugate gradients end with this part of the first residual. [1; > 0; C rounds do the rest]
constexpr double solver_tolerance = 1e-6;
constexpr int most_solver_steps = 200;  // And after so many steps. [steps; > 0; B]
// Faces that grow by less than this under a pressure of one are held by their limits. [pixels; > 0; M 2026-11 set]
constexpr double least_give = 1e-6;

using Segment = std::pair<std::uint32_t, std::uint32_t>;

// Lowers the limits of the segment's ends by the pixel centres near it, row by row.
void keep_off_centres(const std::vector<Vec2>& points, const Segment& segment, double reach,
                      std::vector<double>& limits) {
    const double near = reach / share_to_centre;
    Vec2 a = points[segment.first], b = points[segment.second];
    if (a.y > b.y) std::swap(a, b);
    const bool flat = b.y - a.y <= 2 * near;
    const auto at = [&](double y) {
        return a.x + (std::clamp(y, a.y, b.y) - a.y) * (b.x - a.x) / (b.y - a.y);
    };
    double limit = reach;
    for (double y = std::ceil(a.y - near); y <= b.y + near; ++y) {
        const double one = flat ? a.x : at(y - near), other = flat ? b.x : at(y + near);
        for (double x = std::ceil(std::min(one, other) - near); x <= std::max(one, other) + near; ++x)
            limit = std::min(limit, share_to_centre * distance_to_segment({x, y}, a, b));
    }
    for (const std::uint32_t p : {segment.first, segment.second}) limits[p] = std::min(limits[p], limit);
}

// How far the ends of the segments may move so that no two of them can meet.
void keep_apart(const std::vector<Vec2>& points, const std::vector<Segment>& segments, double reach,
                std::vector<double>& limits) {
    SegmentGrid grid;
    grid.build(static_cast<std::uint32_t>(segments.size()), [&](std::uint32_t s) {
        return std::pair(points[segments[s].first], points[segments[s].second]);
    });
    for (const Segment& segment : segments) {
        for (const std::uint32_t p : {segment.first, segment.second}) {
            const Box2 box = Box2{points[p], points[p]}.grown(reach / share_of_gap);
            grid.query(box, [&](std::uint32_t s) {
                const auto [a, b] = segments[s];
                if (a == p || b == p) return;
                const double gap = distance_to_segment(points[p], points[a], points[b]);
                const double limit = gap < least_gap ? 0 : share_of_gap * gap;
                for (const std::uint32_t q : {p, a, b}) limits[q] = std::min(limits[q], limit);
            });
        }
    }
}

// A point of a face, a ring that has its area inside.
struct Corner {
    std::uint32_t point;
    Vec2 gradient;  // of the face's area when the point moves
};

struct Face {
    std::uint32_t first, count;  // its corners
    double pixels;
};

// The faces of a connected piece of boundary. What bounds the piece from outside has the sum of their areas, so it needs no
// equation of its own.
struct Piece {
    std::vector<Face> faces;
    std::vector<Corner> corners;

    std::span<Corner> corners_of(const Face& face) {
        return std::span(corners).subspan(face.first, face.count);
    }
};

// Moves the points of one piece after another. All vectors have one entry for each point.
class PieceMover {
  public:
    // `weights`: the length of the boundary that a point stands for.
    PieceMover(std::vector<Vec2>& points, const std::vector<double>& weights,
               const std::vector<double>& limits)
        : points_(points), start_(points), stiffness_(weights), limits_(limits), push_(points.size()) {}

    // Returns what the faces still lack, in sum; 0 when each is within its tolerance.
    double move(Piece& piece) {
        double before = std::numeric_limits<double>::infinity();
        for (int round = 0;; ++round) {
            const double lack = find_lacks(piece);
            if (lack == 0 || round == most_rounds || lack > little_progress * before) return lack;
            before = lack;
            find_gradients(piece);
            find_pressures(piece);
            move_points(piece);
        }
    }

  private:
    double find_lacks(Piece& piece) {
        lacks_.clear();
        double sum = 0;
        bool enough = true;
        for (const Face& face : piece.faces) {
            const std::span<const Corner> corners = piece.corners_of(face);
            const Vec2 origin = points_[corners[0].point];
            double twice = 0;
            for (std::size_t i = 1; i + 1 < corners.size(); ++i)
                twice += cross(points_[corners[i].point] - origin, points_[corners[i + 1].point] - origin);
            lacks_.push_back(face.pixels - twice / 2);
            sum += std::abs(lacks_.back());
            enough = enough && std::abs(lacks_.back()) <= area_tolerance * face.pixels;
        }
        return enough ? 0 : sum;
    }

    void find_gradients(Piece& piece) {
        for (const Face& face : piece.faces) {
            const std::span<Corner> corners = piece.corners_of(face);
            for (std::size_t i = 0; i < corners.size(); ++i) {
                const Vec2 before = points_[corners[(i + corners.size() - 1) % corners.size()].point];
                const Vec2 after = points_[corners[(i + 1) % corners.size()].point];
                corners[i].gradient = 0.5 * Vec2{after.y - before.y, before.x - after.x};
            }
        }
    }

    // How the points move under pressures in the faces.
    void push_by(Piece& piece, const std::vector<double>& pressures) {
        for (const Corner& corner : piece.corners) push_[corner.point] = {};
        for (std::size_t f = 0; f < piece.faces.size(); ++f) {
            for (const Corner& corner : piece.corners_of(piece.faces[f])) {
                const double give = pressures[f] / stiffness_[corner.point];
                push_[corner.point] = push_[corner.point] + give * corner.gradient;
            }
        }
    }

    double growth_of(Piece& piece, const Face& face) {
        double growth = 0;
        for (const Corner& corner : piece.corners_of(face))
            growth += dot(corner.gradient, push_[corner.point]);
        return growth;
    }

    // The pressures under which each face grows by what it lacks: conjugate gradients, scaled by the diagonal.
    void find_pressures(Piece& piece) {
        const std::size_t count = piece.faces.size();
        std::vector<double> residuals = lacks_, growths(count), directions(count), own(count);
        double product = 0;
        for (std::size_t f = 0; f < count; ++f) {
            for (const Corner& corner : piece.corners_of(piece.faces[f]))
                own[f] += squared_length(corner.gradient) / stiffness_[corner.point];
            directions[f] = own[f] > least_give ? residuals[f] / own[f] : 0;
            product += residuals[f] * directions[f];
        }
        pressures_.assign(count, 0);
        const double enough = solver_tolerance * solver_tolerance * product;
        for (int step = 0; step < most_solver_steps && product > enough; ++step) {
            push_by(piece, directions);
            double together = 0, alone = 0;
            for (std::size_t f = 0; f < count; ++f) {
                growths[f] = growth_of(piece, piece.faces[f]);
                together += directions[f] * growths[f];
                alone += directions[f] * directions[f] * own[f];
            }
            // Faces that leave each other no room cannot all have what they lack.
            if (!(together > least_give * alone)) break;
            double next = 0;
            for (std::size_t f = 0; f < count; ++f) {
                pressures_[f] += product / together * directions[f];
                residuals[f] -= product / together * growths[f];
                if (own[f] > least_give) next += residuals[f] * residuals[f] / own[f];
            }
            for (std::size_t f = 0; f < count; ++f) {
                if (own[f] > least_give)
                    directions[f] = residuals[f] / own[f] + next / product * directions[f];
            }
            product = next;
        }
    }

    void move_points(Piece& piece) {
        push_by(piece, pressures_);
        for (const Corner& corner : piece.corners) {
            const std::uint32_t p = corner.point;
            const Vec2 push = std::exchange(push_[p], {});  // a point of several faces moves once
            if (push == Vec2{}) continue;
            const Vec2 way = points_[p] + push - start_[p];
            const double distance = length(way);
            if (distance <= limits_[p]) {
                points_[p] = start_[p] + way;
            } else {
                points_[p] = start_[p] + limits_[p] / distance * way;
                stiffness_[p] *= stiffening;
            }
        }
    }

    std::vector<Vec2>& points_;
    const std::vector<Vec2> start_;
    std::vector<double> stiffness_;
    const std::vector<double>& limits_;
    std::vector<Vec2> push_;
    std::vector<double> lacks_, pressures_;  // per face of the piece
};

// The kept segments of all chains.
std::vector<Segment> kept_segments(const ChainNetwork& network, std::span<const std::uint8_t> kept) {
    std::vector<Segment> segments;
    for (std::size_t c = 0; c < network.size(); ++c) {
        const std::span<const std::uint32_t> chain = network.chain(c);
        const auto is_kept = [&](std::uint32_t p) { return kept[p] != 0; };
        const auto first = std::find_if(chain.begin(), chain.end(), is_kept);
        std::uint32_t last = *first;
        for (auto p = first + 1; p < chain.end(); ++p) {
            if (is_kept(*p)) segments.emplace_back(std::exchange(last, *p), *p);
        }
        // The first point of a loop, which is its last one too, may be left out.
        if (chain.front() == chain.back() && !is_kept(chain.front())) segments.emplace_back(last, *first);
    }
    return segments;
}

// Rings are of one piece where chains join them.
std::vector<Piece> pieces_of(const TracedGrid& traced, std::span<const std::uint8_t> kept) {
    const ChainNetwork& network = traced.network;
    std::vector<std::uint32_t> parent(network.points.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t p) {
        while (parent[p] != p) p = parent[p] = parent[parent[p]];
        return p;
    };
    for (std::size_t c = 0; c < network.size(); ++c) {
        const std::uint32_t a = root(network.chain(c).front()), b = root(network.chain(c).back());
        parent[std::max(a, b)] = std::min(a, b);
    }
    std::vector<Piece> pieces;
    std::vector<std::uint32_t> piece_of(network.points.size(), 0);  // of a root, counted from 1
    std::vector<std::uint32_t> ring_points;
    for (const std::vector<TracedRing>* rings : {&traced.rings, &traced.outside}) {
        for (const TracedRing& ring : *rings) {
            if (ring.pixels < 0) continue;
            std::uint32_t& number = piece_of[root(network.chain(traced.links[ring.first] / 2).front())];
            if (number == 0) {
                pieces.emplace_back();
                number = static_cast<std::uint32_t>(pieces.size());
            }
            Piece& piece = pieces[number - 1];
            const auto first = static_cast<std::uint32_t>(piece.corners.size());
            ring_points.clear();
            append_ring_points(traced, ring, ring_points);
            for (const std::uint32_t p : ring_points) {
                if (kept[p]) piece.corners.push_back({p, {}});
            }
            piece.faces.push_back({first, static_cast<std::uint32_t>(piece.corners.size()) - first,
                                   static_cast<double>(ring.pixels)});
        }
    }
    return pieces;
}

}  // namespace

void restore_areas(TracedGrid& traced, std::span<const std::uint8_t> kept, double epsilon) {
    if (traced.rings.empty()) return;
    std::vector<Vec2>& points = traced.network.points;
    const std::vector<Vec2> traced_points = points;
    const std::vector<Segment> segments = kept_segments(traced.network, kept);
    std::vector<Piece> pieces = pieces_of(traced, kept);
    std::vector<double> weights(points.size(), 0), limits(points.size());
    for (const auto& [a, b] : segments) {
        const double half = length(points[b] - points[a]) / 2;
        weights[a] += half;
        weights[b] += half;
    }
    const double reach = std::max(least_reach, epsilon);
    double before = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < most_passes; ++pass) {
        for (std::size_t p = 0; p < points.size(); ++p)
            limits[p] = std::max(0.0, reach - length(points[p] - traced_points[p]));
        keep_apart(points, segments, reach, limits);
        if (epsilon < clear_of_centres) {
            for (const Segment& segment : segments) keep_off_centres(points, segment, reach, limits);
        }
        PieceMover mover(points, weights, limits);
        double lack = 0;
        for (Piece& piece : pieces) lack += mover.move(piece);
        if (lack == 0 || lack > little_progress * before) return;
        before = lack;
    }
}

}  // namespace anatomesh
