// For tests: random solids given by formulas, random sets of planes, and the contours that the planes cut.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/geom/section_tracer_for_test.h"

namespace anatomesh::random_solids {

// The same numbers with every standard library.
class Random {
  public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    double unit() { return std::ldexp(static_cast<double>(engine_()), -32); }
    double between(double low, double high) { return low + (high - low) * unit(); }
    int below(int count) { return static_cast<int>(unit() * count); }
    Vec3 direction() {
        for (;;) {
            const Vec3 v{between(-1, 1), between(-1, 1), between(-1, 1)};
            if (squared_length(v) > 0.01 && squared_length(v) <= 1) return normalized(v);
        }
    }

  private:
    std::mt19937 engine_;
};

// A simple body in its own frame.
struct Body {
    enum class Kind { ball, ellipsoid, torus, tube, shell, box };
    static constexpr int kinds = 6;
    Kind kind = Kind::ball;
    Plane frame;
    Vec3 size;                   // half axes | radius, radius of the ring | radius of the tube | half sides
    double thickness = 0;        // of a shell; the rounding of a box
    std::array<Vec3, 3> path{};  // of a tube, in space

    // Negative inside; near the surface the distance from it.
    double distance(Vec3 p) const {
        const Vec2 across = frame.to_plane(p);
        const Vec3 q{across.x, across.y, frame.signed_distance(p)};
        switch (kind) {
            case Kind::ball:
                return length(q) - size.x;
            case Kind::shell:
                return std::abs(length(q) - size.x) - 0.5 * thickness;
            case Kind::torus:
                return length(Vec2{length(across) - size.x, q.z}) - size.y;
            case Kind::ellipsoid: {
                const Vec3 a{q.x / size.x, q.y / size.y, q.z / size.z};
                const Vec3 b{a.x / size.x, a.y / size.y, a.z / size.z};
                const double steep = length(b);
                return steep > 0 ? length(a) * (length(a) - 1) / steep : -std::min({size.x, size.y, size.z});
            }
            case Kind::box: {
                const Vec3 d{std::abs(q.x) - size.x, std::abs(q.y) - size.y, std::abs(q.z) - size.z};
                const Vec3 beyond{std::max(d.x, 0.0), std::max(d.y, 0.0), std::max(d.z, 0.0)};
                return length(beyond) + std::min(std::max({d.x, d.y, d.z}), 0.0) - thickness;
            }
            case Kind::tube:
                break;
        }
        double nearest = 1e300;
        for (int k = 0; k < 2; ++k) {
            const Vec3 way = path[k + 1] - path[k], from = p - path[k];
            const double t = std::clamp(dot(from, way) / dot(way, way), 0.0, 1.0);
            nearest = std::min(nearest, length(from - t * way));
        }
        return nearest - size.x;
    }
};

// Bodies added and taken away in turn, less the solids `beside`.
struct Solid {
    struct Part {
        Body body;
        bool taken_away = false;
    };
    std::vector<Part> parts;
    std::vector<Solid> beside;

    double distance(Vec3 p) const {
        double d = 1e300;
        for (const Part& part : parts) {
            const double own = part.body.distance(p);
            d = part.taken_away ? std::max(d, -own) : std::min(d, own);
        }
        for (const Solid& other : beside) d = std::max(d, -other.distance(p));
        return d;
    }
};

// `spacing` is that of the planes: what is much smaller they cannot see.
inline Body random_body(Random& random, Vec3 centre, double radius, double spacing) {
    Body body;
    body.kind = static_cast<Body::Kind>(random.below(Body::kinds));
    body.frame = make_plane(centre, random.direction());
    switch (body.kind) {
        case Body::Kind::ball:
            body.size.x = radius * random.between(0.6, 1);
            break;
        case Body::Kind::ellipsoid:
            body.size = {radius, radius * random.between(0.5, 1), radius * random.between(0.35, 1)};
            break;
        case Body::Kind::torus:
            body.size = {0.68 * radius, std::max(0.2 * radius, std::min(0.32 * radius, 1.5 * spacing)), 0};
            break;
        case Body::Kind::shell:
            body.thickness = spacing * random.between(1.2, 2.5);
            body.size.x = radius - 0.5 * body.thickness;
            break;
        case Body::Kind::box:
            body.thickness = spacing * random.between(0.4, 1.2);
            body.size = radius * Vec3{random.between(0.25, 0.45), random.between(0.25, 0.45),
                                      random.between(0.25, 0.45)};
            break;
        case Body::Kind::tube:
            body.size.x = spacing * random.between(1, 2);
            for (Vec3& node : body.path) node = centre + (radius - body.size.x) * random.direction();
            break;
    }
    return body;
}

inline Solid random_solid(Random& random, Vec3 centre, double radius, double spacing) {
    Solid solid;
    const int parts = 1 + random.below(3);
    for (int k = 0; k < parts; ++k) {
        const double share = k == 0 ? 1 : random.between(0.5, 0.8);
        const Vec3 at = centre + (1 - share) * radius * random.direction();
        const bool taken_away = k > 0 && random.unit() < 0.35;
        solid.parts.push_back({random_body(random, at, share * radius, spacing), taken_away});
    }
    return solid;
}

enum class Arrangement { one, nested, touching, overlapping, mixed };
inline constexpr int arrangements = 5;
inline constexpr std::array<const char*, arrangements> arrangement_names{"one", "nested", "touching",
                                                                         "overlapping", "mixed"};

inline Solid ball(Vec3 centre, double radius) {
    Solid solid;
    Body body;
    body.frame = make_plane(centre, {0, 0, 1});
    body.size.x = radius;
    solid.parts.push_back({body, false});
    return solid;
}

// Solids within the ball of the radius about the origin.
inline std::vector<Solid> random_structures(Random& random, Arrangement arrangement, double radius,
                                            double spacing) {
    const auto beside = [](Solid solid, const Solid& other) {
        solid.beside.push_back(other);
        return solid;
    };
    const Vec3 side = random.direction();
    switch (arrangement) {
        case Arrangement::one:
            return {random_solid(random, {}, radius, spacing)};
        case Arrangement::nested:
            return {ball({}, radius), random_solid(random, 0.15 * radius * side, 0.6 * radius, spacing)};
        case Arrangement::touching: {
            const Solid first = random_solid(random, -0.35 * radius * side, 0.65 * radius, spacing);
            return {first, beside(random_solid(random, 0.35 * radius * side, 0.65 * radius, spacing), first)};
        }
        case Arrangement::overlapping:
            return {random_solid(random, -0.3 * radius * side, 0.7 * radius, spacing),
                    random_solid(random, 0.3 * radius * side, 0.7 * radius, spacing)};
        case Arrangement::mixed:
            break;
    }
    const Solid first = random_solid(random, -0.4 * radius * side, 0.6 * radius, spacing);
    return {first, beside(ball(0.3 * radius * side, 0.7 * radius), first),
            random_solid(random, 0.35 * radius * side, 0.4 * radius, spacing)};
}

enum class Planes { parallel, uneven, tilted, fan, rotational, freehand, crossing_stacks };
inline constexpr int plane_sets = 7;
inline constexpr std::array<const char*, plane_sets> plane_set_names{
    "parallel", "uneven", "tilted", "fan", "rotational", "freehand", "crossing stacks"};

// Planes about `spacing` apart at the rim of the ball of the radius about the origin.
inline std::vector<Plane> random_planes(Random& random, Planes kind, double radius, double spacing) {
    std::vector<Plane> planes;
    const auto stack = [&](Vec3 normal, double gap, double uneven, double tilt) {
        for (double h = -radius + gap * random.between(0, 0.5); h < radius;
             h += gap * (1 + uneven * random.between(-1, 1))) {
            const Vec3 n = normalized(normal + tilt * random.direction());
            planes.push_back(make_plane(h * normal + (tilt * gap) * random.direction(), n));
        }
    };
    switch (kind) {
        case Planes::parallel:
            stack({0, 0, 1}, spacing, 0, 0);
            break;
        case Planes::uneven:
            stack({0, 0, 1}, spacing, 0.6, 0);
            break;
        case Planes::tilted:
            stack(random.direction(), spacing, 0, 0);
            break;
        case Planes::freehand:
            stack(random.direction(), spacing, 0.3, 0.06);
            break;
        case Planes::crossing_stacks: {
            const Plane frame = make_plane({}, random.direction());
            for (const Vec3 normal : {frame.u, frame.v, frame.normal}) stack(normal, 2 * spacing, 0, 0);
            break;
        }
        case Planes::fan: {
            const double away = radius * random.between(1.5, 3);
            const Plane frame = make_plane({}, random.direction());
            const Vec3 apex = -away * frame.u;
            const double half = std::asin(radius / away), step = spacing / away;
            for (double a = -half + step * random.between(0, 0.5); a < half; a += step)
                planes.push_back(make_plane(apex, std::cos(a) * frame.v - std::sin(a) * frame.u));
            break;
        }
        case Planes::rotational: {
            const Plane frame = make_plane(0.1 * radius * random.direction(), random.direction());
            const int count = static_cast<int>(std::numbers::pi * radius / spacing);
            for (int k = 0; k < count; ++k) {
                const double a = std::numbers::pi * k / count;
                planes.push_back(make_plane(frame.origin, std::cos(a) * frame.u + std::sin(a) * frame.v));
            }
            break;
        }
    }
    return planes;
}

// What comes between what the planes cut and the file.
enum class Spoiling {
    none,
    rounded,      // coordinates of few decimals, and planes that are not said
    out_of_place  // every plane by a movement of its own, as a patient breathes and a probe is tracked
};
inline constexpr int spoilings = 3;
inline constexpr std::array<const char*, spoilings> spoiling_names{"", ", rounded", ", out of place"};

// One case: the truth, and the contours as a file would give them.
struct Case {
    std::string name;
    Planes planes = Planes::parallel;
    Spoiling spoiling = Spoiling::none;
    Arrangement arrangement = Arrangement::one;
    Sampling sampling;
    double radius = 0, spacing = 0;
    std::vector<Solid> structures;
    RawContours drawn;
};

// To hundredths of a millimetre.
inline void round_off(RawContours& drawn) {
    const auto rounded = [](double value) { return std::round(100 * value) / 100; };
    for (Vec3& p : drawn.points) p = {rounded(p.x), rounded(p.y), rounded(p.z)};
    for (RawContour& contour : drawn.contours) {
        contour.slice = drawn.plane_names[static_cast<std::size_t>(contour.plane)];
        contour.plane = -1;
    }
    drawn.planes.clear();
    drawn.plane_names.clear();
}

// By up to 0.8 mm along each axis and 0.8 degrees about each axis through the middle of its points.
inline void put_out_of_place(RawContours& drawn, Random& random) {
    constexpr double most_mm = 0.8, most_angle = 0.8 * std::numbers::pi / 180;
    const auto any = [&](double most) {
        return Vec3{random.between(-most, most), random.between(-most, most), random.between(-most, most)};
    };
    for (std::size_t k = 0; k < drawn.planes.size(); ++k) {
        std::vector<Vec3*> points;
        for (const RawContour& contour : drawn.contours) {
            if (contour.plane != static_cast<std::int32_t>(k)) continue;
            for (std::uint32_t n = 0; n < contour.point_count; ++n)
                points.push_back(&drawn.points[contour.first_point + n]);
        }
        Vec3 middle;
        for (const Vec3* p : points) middle += (1 / static_cast<double>(points.size())) * *p;
        const Vec3 shift = any(most_mm), turn = any(most_angle);
        const double angle = length(turn);
        const Vec3 axis = (1 / angle) * turn;
        const auto turned = [&](Vec3 v) {  // Rodrigues
            return std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
                   ((1 - std::cos(angle)) * dot(axis, v)) * axis;
        };
        Plane& plane = drawn.planes[k];
        plane = make_plane(middle + turned(plane.origin - middle) + shift, turned(plane.normal));
        for (Vec3* p : points) *p = middle + turned(*p - middle) + shift;
    }
}

// The same drawings four times: with few planes, with half as many again, and the first as files may give
// them: rounded, and out of place.
inline constexpr std::uint32_t coarse_cases = 500, exact_cases = 2 * coarse_cases,
                               all_cases = 4 * coarse_cases;

inline Case random_case(std::uint32_t case_number) {
    const std::uint32_t number = case_number % coarse_cases;
    const bool fine = case_number >= coarse_cases && case_number < exact_cases;
    Random random(1000 + number);
    Case made;
    made.planes = static_cast<Planes>(number % plane_sets);
    made.arrangement = static_cast<Arrangement>(number / plane_sets % arrangements);
    made.radius = random.between(20, 40);
    // Planes that all cross each other make the most work.
    const bool crossing = made.planes == Planes::rotational || made.planes == Planes::crossing_stacks;
    made.spacing = 2 * made.radius /
                   random.between(fine       ? 13
                                  : crossing ? 7
                                             : 9,
                                  fine       ? 20
                                  : crossing ? 10
                                             : 13);
    made.sampling.grid = made.spacing * random.between(0.5, 1);
    made.sampling.sparse = random.unit() < 0.5;
    if (made.sampling.sparse) made.sampling.grid *= 0.5;
    made.sampling.alike = random.unit() < 0.7;
    made.name = "case " + std::to_string(case_number) + ": " + plane_set_names[number % plane_sets] + ", " +
                arrangement_names[number / plane_sets % arrangements] +
                (made.sampling.sparse ? ", sparse" : "") + (made.sampling.alike ? "" : ", by several hands");
    if (case_number >= exact_cases)
        made.spoiling = case_number < exact_cases + coarse_cases ? Spoiling::rounded : Spoiling::out_of_place;
    made.name += spoiling_names[static_cast<std::size_t>(made.spoiling)];
    made.structures = random_structures(random, made.arrangement, made.radius, made.spacing);
    made.drawn.planes = random_planes(random, made.planes, made.radius, made.spacing);
    for (std::size_t s = 0; s < made.structures.size(); ++s) {
        const auto id = static_cast<std::int32_t>(s) + 1;
        made.drawn.structures.push_back({id, "structure " + std::to_string(id), {}});
    }
    for (std::size_t k = 0; k < made.drawn.planes.size(); ++k) {
        SectionTracer tracer(made.drawn.planes[k], made.radius, made.sampling);
        made.drawn.plane_names.push_back("plane " + std::to_string(k));
        for (std::size_t s = 0; s < made.structures.size(); ++s) {
            for (const std::vector<Vec3>& loop :
                 tracer.trace(made.structures[s], static_cast<std::uint32_t>(s))) {
                RawContour contour;
                contour.structure = static_cast<std::uint32_t>(s);
                contour.first_point = static_cast<std::uint32_t>(made.drawn.points.size());
                contour.point_count = static_cast<std::uint32_t>(loop.size());
                contour.plane = static_cast<std::int32_t>(k);
                contour.name = "contour " + std::to_string(made.drawn.contours.size());
                made.drawn.contours.push_back(contour);
                made.drawn.points.insert(made.drawn.points.end(), loop.begin(), loop.end());
            }
        }
    }
    if (made.spoiling == Spoiling::rounded) round_off(made.drawn);
    if (made.spoiling == Spoiling::out_of_place) {
        Random of_places(5000 + number);
        put_out_of_place(made.drawn, of_places);
    }
    return made;
}

}  // namespace anatomesh::random_solids
