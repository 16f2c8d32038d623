// For tests: solids given by formulas, cut by stacks, sweeps and fans, and mistakes of drawing on one of the slices.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/section_tracer_for_test.h"

namespace anatomesh::wrong_slices {

// The same numbers with every standard library.
class Random {
  public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    double unit() { return std::ldexp(static_cast<double>(engine_()), -32); }
    double between(double low, double high) { return low + (high - low) * unit(); }
    int below(int count) { return static_cast<int>(unit() * count); }

  private:
    std::mt19937 engine_;
};

struct Solid {
    std::function<double(Vec3)> of;  // negative inside
    double distance(Vec3 p) const { return of(p); }
};

// The distance from a path of points, less its radius, which goes from one end to the other in proportion.
inline double tube_distance(const std::vector<Vec3>& path, double first, double last, Vec3 p) {
    double nearest = 1e300;
    for (std::size_t k = 0; k + 1 < path.size(); ++k) {
        const Vec3 way = path[k + 1] - path[k], from = p - path[k];
        const double t = std::clamp(dot(from, way) / dot(way, way), 0.0, 1.0);
        const double along = (static_cast<double>(k) + t) / static_cast<double>(path.size() - 1);
        nearest = std::min(nearest, length(from - t * way) - (first + along * (last - first)));
    }
    return nearest;
}

inline double ellipsoid_distance(Vec3 centre, Vec3 half, Vec3 p) {
    const Vec3 q{(p.x - centre.x) / half.x, (p.y - centre.y) / half.y, (p.z - centre.z) / half.z};
    const Vec3 g{q.x / half.x, q.y / half.y, q.z / half.z};
    const double steep = length(g);
    return steep > 0 ? length(q) * (length(q) - 1) / steep : -std::min({half.x, half.y, half.z});
}

enum class Family { ellipsoid, tube, branches, ring, hollow, two_parts, three_structures, cone, rod, lobed };
inline constexpr int families = 10;
inline constexpr std::array<const char*, families> family_names{
    "ellipsoid", "bent tube",        "branches", "ring", "hollow",
    "two parts", "three structures", "cone",     "rod",  "lobed"};

// Structures within the ball of the radius about the origin; slices follow z. `gap`: between slices.
inline std::vector<Solid> structures_of(Random& random, Family family, double radius, double gap) {
    const double r = radius;
    const auto bent = [&](Vec3 aside) {
        std::vector<Vec3> path;
        const double bow = random.between(-0.35, 0.35) * r, lean = random.between(-0.3, 0.3) * r,
                     turn = random.between(0, 6.28);
        for (int k = 0; k <= 16; ++k) {
            const double s = -1 + k / 8.0, across = bow * (1 - s * s) + lean * s;
            path.push_back(aside + Vec3{across * std::cos(turn), across * std::sin(turn), 0.85 * r * s});
        }
        return path;
    };
    const auto tube = [](std::vector<Vec3> path, double first, double last) {
        return Solid{
            [path = std::move(path), first, last](Vec3 p) { return tube_distance(path, first, last, p); }};
    };
    switch (family) {
        case Family::ellipsoid: {
            const Vec3 half{r * random.between(0.3, 0.8), r * random.between(0.3, 0.8),
                            r * random.between(0.7, 0.95)};
            const double turn = random.between(0, 0.7);
            return {Solid{[=](Vec3 p) {
                const Vec3 q{std::cos(turn) * p.x + std::sin(turn) * p.z, p.y,
                             std::cos(turn) * p.z - std::sin(turn) * p.x};
                return ellipsoid_distance({}, half, q);
            }}};
        }
        case Family::tube:
            return {tube(bent({}), r * random.between(0.12, 0.3), r * random.between(0.12, 0.3))};
        case Family::branches: {
            const double width = r * random.between(0.12, 0.22), open = random.between(0.25, 0.5),
                         turn = random.between(0, 6.28);
            const Vec3 side{std::cos(turn), std::sin(turn), 0};
            const std::vector<Vec3> trunk{{0, 0, -0.85 * r}, {0, 0, 0}},
                left{{0, 0, 0}, open * r * side + Vec3{0, 0, 0.8 * r}},
                right{{0, 0, 0}, (-open * r) * side + Vec3{0, 0, 0.8 * r}};
            const double last = random.between(0.6, 0.9) * width;
            return {Solid{[=](Vec3 p) {
                return std::min({tube_distance(trunk, width, width, p), tube_distance(left, width, last, p),
                                 tube_distance(right, width, last, p)});
            }}};
        }
        case Family::ring: {
            const double wide = r * random.between(0.5, 0.65), thin = r * random.between(0.15, 0.25),
                         lean = random.between(0, 1.5);
            return {Solid{[=](Vec3 p) {
                const double y = std::cos(lean) * p.y + std::sin(lean) * p.z,
                             z = std::cos(lean) * p.z - std::sin(lean) * p.y;
                return length(Vec2{length(Vec2{p.x, y}) - wide, z}) - thin;
            }}};
        }
        case Family::hollow: {
            const std::vector<Vec3> path = bent({});
            const double wide = r * random.between(0.22, 0.4), lumen = wide * random.between(0.35, 0.75);
            return {Solid{[=](Vec3 p) {
                return std::max(tube_distance(path, wide, wide, p), -tube_distance(path, lumen, lumen, p));
            }}};
        }
        case Family::two_parts: {
            const double wide = r * random.between(0.1, 0.22);
            const std::vector<Vec3> one = bent({0.45 * r, 0, 0}), other = bent({-0.45 * r, 0, 0});
            return {Solid{[=](Vec3 p) {
                return std::min(tube_distance(one, wide, 0.8 * wide, p),
                                tube_distance(other, 0.8 * wide, wide, p));
            }}};
        }
        case Family::three_structures: {
            const double wide = r * random.between(0.12, 0.2);
            return {tube(bent({0.5 * r, 0, 0}), wide, wide), tube(bent({-0.5 * r, 0, 0}), wide, 0.7 * wide),
                    Solid{[=](Vec3 p) {
                        return ellipsoid_distance({0, 0.55 * r, 0}, {0.25 * r, 0.2 * r, 0.7 * r}, p);
                    }}};
        }
        case Family::cone:
            return {tube({{0, 0, -0.7 * r}, {0.2 * r, 0, 0.8 * r}}, r * random.between(0.3, 0.45),
                         r * random.between(0.04, 0.12))};
        case Family::rod: {
            const double lean = random.between(0, 0.8),
                         thin = std::max(random.between(0.06, 0.1) * r, 0.5 * gap);
            return {tube({{-lean * 0.5 * r, 0, -0.75 * r}, {lean * 0.5 * r, 0, 0.75 * r}}, thin, thin)};
        }
        case Family::lobed:
            break;
    }
    const std::array<double, 4> turn{random.between(0, 6.28), random.between(0, 6.28),
                                     random.between(0, 6.28), random.between(0, 6.28)};
    return {Solid{[=](Vec3 p) {
        double nearest = ellipsoid_distance({}, {0.45 * r, 0.4 * r, 0.75 * r}, p);
        for (std::size_t k = 0; k < 4; ++k) {
            const double z = (static_cast<double>(k) - 1.5) * 0.3 * r;
            nearest = std::min(
                nearest,
                length(p - Vec3{0.42 * r * std::cos(turn[k]), 0.42 * r * std::sin(turn[k]), z}) - 0.26 * r);
        }
        return nearest;
    }}};
}

enum class Planes { parallel, uneven, sweep, fan };
inline constexpr int plane_sets = 4;
inline constexpr std::array<const char*, plane_sets> plane_set_names{"parallel", "uneven", "sweep", "fan"};

inline std::vector<Plane> planes_of(Random& random, Planes kind, double radius, double gap) {
    std::vector<Plane> planes;
    if (kind == Planes::fan) {
        const double away = radius * random.between(1.6, 3), half = std::asin(radius / away),
                     step = gap / away;
        for (double a = -half + step * random.unit(); a < half; a += step)
            planes.push_back(make_plane({-away, 0, 0}, {-std::sin(a), 0, std::cos(a)}));
        return planes;
    }
    const double phase = random.between(0, 6.28),
                 lean = kind == Planes::sweep ? random.between(0.02, 0.1) : 0;
    for (double z = -radius + gap * random.unit(); z < radius;
         z += gap * (kind == Planes::uneven ? random.between(0.6, 1.4) : 1)) {
        const double wobble = lean * std::sin(phase + 3 * z / radius);
        planes.push_back(make_plane({0, 0, z}, {wobble, 0.5 * wobble, 1}));
    }
    return planes;
}

// A closed outline on a slice; its points are in the plane's coordinates.
using Outline = std::vector<Vec2>;

inline Vec2 centre_of(const Outline& outline) {
    double area = 0;
    Vec2 moment;
    for (std::size_t n = 0; n < outline.size(); ++n) {
        const Vec2 a = outline[n] - outline[0], b = outline[(n + 1) % outline.size()] - outline[0];
        area += 0.5 * cross(a, b);
        moment = moment + (cross(a, b) / 6) * (a + b);
    }
    return area != 0 ? outline[0] + (1 / area) * moment : outline[0];
}
inline double area_of(const Outline& outline) {
    return std::abs(signed_area(outline));
}
inline double radius_of(const Outline& outline) {
    return std::sqrt(area_of(outline) / std::numbers::pi);
}
inline bool holds(const Outline& outline, Vec2 p) {
    return side_of_polygon(outline, p) == Side::inside;
}

struct Drawing {
    std::string name;
    Family family = Family::ellipsoid;
    Planes arrangement = Planes::parallel;
    double gap = 0;
    std::vector<Plane> planes;
    std::vector<std::vector<std::vector<Outline>>> drawn;  // by slice, then by structure
    std::size_t structures = 0;
};

// `shake_mm`: each slice is moved by as much in its plane, as hands draw.
inline Drawing drawing_of(std::uint32_t number, double shake_mm = 0) {
    Random random(7000 + number);
    Drawing drawing;
    drawing.family = static_cast<Family>(number % families);
    drawing.arrangement = static_cast<Planes>(number / families % plane_sets);
    const double radius = random.between(20, 40);
    const int slices = 5 + random.below(22);
    drawing.gap = 1.7 * radius / slices;
    const std::vector<Solid> solids = structures_of(random, drawing.family, radius, drawing.gap);
    drawing.structures = solids.size();
    drawing.name = "case " + std::to_string(number) + ": " +
                   family_names[static_cast<std::size_t>(drawing.family)] + ", " +
                   plane_set_names[static_cast<std::size_t>(drawing.arrangement)] + ", " +
                   std::to_string(slices) + " slices";
    random_solids::Sampling sampling;
    sampling.grid = radius * random.between(0.03, 0.06);
    for (const Plane& plane : planes_of(random, drawing.arrangement, radius, drawing.gap)) {
        random_solids::SectionTracer tracer(plane, 1.3 * radius, sampling);
        std::vector<std::vector<Outline>> slice(solids.size());
        const Vec2 shake{shake_mm * random.between(-1, 1), shake_mm * random.between(-1, 1)};
        for (std::size_t s = 0; s < solids.size(); ++s) {
            for (const std::vector<Vec3>& loop : tracer.trace(solids[s], static_cast<std::uint32_t>(s))) {
                Outline outline;
                for (const Vec3& p : loop) outline.push_back(plane.to_plane(p) + shake);
                if (area_of(outline) > 0.01 * sampling.grid * sampling.grid)
                    slice[s].push_back(std::move(outline));
            }
        }
        drawing.planes.push_back(plane);
        drawing.drawn.push_back(std::move(slice));
    }
    return drawing;
}

inline RawContours raw_of(const Drawing& drawing) {
    RawContours raw;
    raw.source = "test";
    for (std::size_t s = 0; s < drawing.structures; ++s)
        raw.structures.push_back(
            {static_cast<std::int32_t>(s) + 1, "structure " + std::to_string(s + 1), {}});
    raw.planes = drawing.planes;
    for (std::size_t k = 0; k < drawing.planes.size(); ++k) {
        raw.plane_names.push_back("slice " + std::to_string(k));
        for (std::size_t s = 0; s < drawing.structures; ++s) {
            for (const Outline& outline : drawing.drawn[k][s]) {
                RawContour contour;
                contour.structure = static_cast<std::uint32_t>(s);
                contour.first_point = static_cast<std::uint32_t>(raw.points.size());
                contour.point_count = static_cast<std::uint32_t>(outline.size());
                contour.plane = static_cast<std::int32_t>(k);
                for (const Vec2 p : outline) raw.points.push_back(drawing.planes[k].to_space(p));
                raw.contours.push_back(contour);
            }
        }
    }
    return raw;
}

// Whether an outline is a hole of those of its structure.
inline bool is_hole(const std::vector<Outline>& outlines, const Outline& one) {
    int around = 0;
    for (const Outline& other : outlines) around += &other != &one && holds(other, one[0]);
    return around % 2 == 1;
}

inline bool is_inside(const std::vector<Outline>& outlines, Vec2 p) {
    bool inside = false;
    for (const Outline& outline : outlines) inside ^= holds(outline, p);
    return inside;
}

enum class Mistake {
    drawn_twice,
    part_missing,
    lumen_missing,
    lumen_aside,
    twice_as_wide,
    a_tenth,
    turned,
    exchanged,
    stray,
    speck,
    part_aside,
    structure_aside,
    short_stack_aside
};
inline constexpr int mistakes = 13;
inline constexpr std::array<const char*, mistakes> mistake_names{
    "drawn twice", "part missing",         "lumen missing",    "lumen aside", "twice as wide",
    "a tenth",     "turned by 90 degrees", "two exchanged",    "stray click", "speck inside",
    "part aside",  "structure aside",      "short stack aside"};

struct Wrong {
    Drawing drawing;
    std::vector<std::size_t> slices;  // that are wrong
    std::size_t structure = 0;
    bool is_topological = false;
    double volume_share = 0;  // of the structure, that is elsewhere than it was
};

inline Outline mapped(const Outline& outline, const std::function<Vec2(Vec2)>& map) {
    Outline result;
    for (const Vec2 p : outline) result.push_back(map(p));
    return result;
}

// The area in which two drawings of a slice differ, and of the first.
inline std::array<double, 2> difference_of(const std::vector<Outline>& before,
                                           const std::vector<Outline>& after) {
    Box2 box;
    for (const auto* outlines : {&before, &after}) {
        for (const Outline& outline : *outlines)
            for (const Vec2 p : outline) box.extend(p);
    }
    constexpr int steps = 60;
    const Vec2 step{(box.high.x - box.low.x) / steps, (box.high.y - box.low.y) / steps};
    std::array<double, 2> count{0, 0};
    for (int j = 0; j < steps; ++j) {
        for (int i = 0; i < steps; ++i) {
            const Vec2 p{box.low.x + (i + 0.5) * step.x, box.low.y + (j + 0.5) * step.y};
            const bool was = is_inside(before, p);
            count[0] += was != is_inside(after, p);
            count[1] += was;
        }
    }
    return {count[0] * step.x * step.y, count[1] * step.x * step.y};
}

// A drawing with a mistake, which differs from the right one by 3 % of the structure's volume or its topology; nothing
// where the drawing offers no place for it. The structure goes on over both slices beside.
inline std::optional<Wrong> wrong_of(std::uint32_t number, Mistake mistake, double shake_mm = 0) {
    Wrong wrong;
    wrong.drawing = drawing_of(number, shake_mm);
    Drawing& drawing = wrong.drawing;
    Random random(90000 + number);
    if (mistake == Mistake::structure_aside && drawing.structures < 2) return std::nullopt;
    wrong.structure = static_cast<std::size_t>(random.below(static_cast<int>(drawing.structures)));
    const std::size_t s = wrong.structure;
    std::vector<std::size_t> with;
    for (std::size_t k = 0; k < drawing.planes.size(); ++k) {
        if (!drawing.drawn[k][s].empty()) with.push_back(k);
    }
    if (mistake == Mistake::short_stack_aside) {
        const auto count = static_cast<std::size_t>(3 + random.below(5));
        if (with.size() < count || drawing.structures > 1) return std::nullopt;
        const std::size_t first = with[(with.size() - count) / 2];
        drawing.planes = {drawing.planes.begin() + static_cast<std::ptrdiff_t>(first),
                          drawing.planes.begin() + static_cast<std::ptrdiff_t>(first + count)};
        drawing.drawn = {drawing.drawn.begin() + static_cast<std::ptrdiff_t>(first),
                         drawing.drawn.begin() + static_cast<std::ptrdiff_t>(first + count)};
        with.clear();
        for (std::size_t k = 0; k < count; ++k) with.push_back(k);
    }
    if (with.size() < 3) return std::nullopt;
    const auto right = drawing.drawn;
    for (int tries = 0; tries < 12; ++tries) {
        const std::size_t at =
            mistake == Mistake::short_stack_aside
                ? with[with.size() / 2]
                : with[1 + static_cast<std::size_t>(random.below(static_cast<int>(with.size()) - 2))];
        std::vector<Outline>& here = drawing.drawn[at][s];
        const auto largest = static_cast<std::size_t>(
            std::max_element(here.begin(), here.end(),
                             [](const Outline& a, const Outline& b) { return area_of(a) < area_of(b); }) -
            here.begin());
        const Vec2 middle = centre_of(here[largest]);
        const double radius = radius_of(here[largest]);
        const double turn = random.between(0, 6.28);
        const Vec2 way{std::cos(turn), std::sin(turn)};
        const auto goes_on = [&](const Outline& one) {  // on both slices beside
            const Vec2 p = centre_of(one);
            const bool solid = is_inside(right[at][s], p);
            for (const std::size_t k : {at - 1, at + 1}) {
                const Vec2 q = drawing.planes[k].to_plane(drawing.planes[at].to_space(p));
                if (is_inside(right[k][s], q) != solid) return false;
            }
            return true;
        };
        std::vector<std::size_t> holes, parts;
        for (std::size_t n = 0; n < here.size(); ++n) (is_hole(here, here[n]) ? holes : parts).push_back(n);
        wrong.slices = {at};
        wrong.is_topological = false;
        bool done = false;
        switch (mistake) {
            case Mistake::drawn_twice:
                if (radius > 4 && goes_on(here[largest])) {
                    here.push_back(mapped(here[largest], [&](Vec2 p) {
                        return middle + ((radius - 1) / radius) * (p - middle);
                    }));
                    if (holes.empty()) done = wrong.is_topological = true;
                }
                break;
            case Mistake::part_missing:
                if (parts.size() > 1 && holes.empty()) {
                    const std::size_t part =
                        parts[static_cast<std::size_t>(random.below(static_cast<int>(parts.size())))];
                    if (!goes_on(here[part])) break;
                    here.erase(here.begin() + static_cast<std::ptrdiff_t>(part));
                    done = wrong.is_topological = true;
                }
                break;
            case Mistake::lumen_missing:
                if (holes.size() == 1 && goes_on(here[holes[0]])) {
                    here.erase(here.begin() + static_cast<std::ptrdiff_t>(holes[0]));
                    done = wrong.is_topological = true;
                }
                break;
            case Mistake::lumen_aside:
                if (holes.size() == 1 && parts.size() == 1 && goes_on(here[holes[0]])) {
                    // As a lumen of its wall's thickness, pushed to one side.
                    const Vec2 from = centre_of(here[holes[0]]);
                    const double shrink = std::min(1.0, 0.35 * radius / radius_of(here[holes[0]]));
                    const Vec2 to = middle + 0.6 * radius * way;
                    const Outline moved =
                        mapped(here[holes[0]], [&](Vec2 p) { return to + shrink * (p - from); });
                    if (std::all_of(moved.begin(), moved.end(),
                                    [&](Vec2 p) { return holds(here[parts[0]], p); })) {
                        here[holes[0]] = moved;
                        done = true;
                    }
                }
                break;
            case Mistake::twice_as_wide:
            case Mistake::a_tenth: {
                const double factor = mistake == Mistake::a_tenth ? 0.1 : 2;
                if (parts.size() == 1) {
                    for (Outline& one : here)
                        one = mapped(one, [&](Vec2 p) { return middle + factor * (p - middle); });
                    done = true;
                }
                break;
            }
            case Mistake::turned:
                if (parts.size() == 1) {
                    for (Outline& one : here)
                        one = mapped(one, [&](Vec2 p) {
                            return middle + Vec2{middle.y - p.y, p.x - middle.x};
                        });
                    done = true;
                }
                break;
            case Mistake::exchanged: {
                if (with.size() < 6) break;
                const std::size_t other =
                    with[1 + static_cast<std::size_t>(random.below(static_cast<int>(with.size()) - 2))];
                if (other + 3 > at && at + 3 > other) break;
                for (std::size_t k = 0; k < drawing.structures; ++k)
                    std::swap(drawing.drawn[at][k], drawing.drawn[other][k]);
                wrong.slices = {at, other};
                done = !drawing.drawn[at][s].empty() && !drawing.drawn[other][s].empty();
                break;
            }
            case Mistake::stray: {
                Outline click;
                const double small = random.between(1, 3);
                for (int n = 0; n < 12; ++n)
                    click.push_back(middle + 40 * way +
                                    small * Vec2{std::cos(n * 0.5236), std::sin(n * 0.5236)});
                double nearest = 1e300;
                for (const std::size_t k : with) {
                    for (const Outline& one : right[k][s])
                        for (const Vec2 p : one) nearest = std::min(nearest, length(p - (middle + 40 * way)));
                }
                if (nearest < 12) break;
                here.push_back(click);
                done = wrong.is_topological = true;
                break;
            }
            case Mistake::speck: {
                const Vec2 p = middle + 0.4 * radius * way;
                if (!is_inside(here, p)) break;
                Outline speck;
                for (int n = 0; n < 5; ++n)
                    speck.push_back(p + 0.3 * Vec2{std::cos(n * 1.2566), std::sin(n * 1.2566)});
                if (!std::all_of(speck.begin(), speck.end(), [&](Vec2 q) { return is_inside(here, q); }) ||
                    !goes_on(speck))
                    break;
                here.push_back(speck);
                done = wrong.is_topological = true;
                break;
            }
            case Mistake::part_aside:
                if (parts.size() == 2 && holes.empty() && goes_on(here[parts[0]])) {
                    here[parts[0]] = mapped(here[parts[0]], [&](Vec2 p) { return p + 6 * way; });
                    done = std::none_of(here[parts[0]].begin(), here[parts[0]].end(),
                                        [&](Vec2 p) { return holds(here[parts[1]], p); });
                }
                break;
            case Mistake::structure_aside:
            case Mistake::short_stack_aside:
                if (!goes_on(here[largest])) break;
                for (Outline& one : here) one = mapped(one, [&](Vec2 p) { return p + 8 * way; });
                done = true;
                break;
        }
        if (done) {
            double volume = 0, changed = 0;
            for (const std::size_t k : with) {
                double area = 0;
                for (const Outline& one : right[k][s])
                    area += (is_hole(right[k][s], one) ? -1 : 1) * area_of(one);
                volume += area;
            }
            // Both slices of an exchange must be far off.
            changed = 1e300;
            for (const std::size_t k : wrong.slices)
                changed = std::min(changed, difference_of(right[k][s], drawing.drawn[k][s])[0]);
            wrong.volume_share = changed / volume;
            if (wrong.is_topological || wrong.volume_share >= 0.03) return wrong;
        }
        drawing.drawn = right;
    }
    return std::nullopt;
}

}  // namespace anatomesh::wrong_slices
