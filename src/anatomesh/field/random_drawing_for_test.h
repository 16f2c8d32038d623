// Random drawings of slices that lie in many ways, and random edits of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh::fixtures {

enum class Lie { even, uneven, tilted, sweep, fan };

// What is drawn of a structure on a slice: 0 nothing, else the seed of its outlines.
struct DrawnSlices {
    std::vector<Plane> planes;
    std::vector<std::vector<std::uint32_t>> seeds;  // by slice, then structure
    bool exclusive = false;
};

inline DrawnSlices random_drawing(Lie lie, bool exclusive, std::mt19937& random) {
    DrawnSlices drawing;
    drawing.exclusive = exclusive;
    const std::size_t slices = 7 + random() % 6, structures = exclusive ? 2 : 1 + random() % 3;
    const Plane axis = make_plane({}, {0, 0, 1});
    double z = 0;
    for (std::size_t k = 0; k < slices; ++k) {
        const double share = static_cast<double>(k) / static_cast<double>(slices);
        Plane plane = axial(z);
        if (lie == Lie::tilted) plane = make_plane({0.3 * z, 0, z}, {0.3, 0.2, 1});
        if (lie == Lie::sweep) plane = make_plane({0, 0, z}, {0.02 * static_cast<double>(k), 0, 1});
        if (lie == Lie::fan)
            plane = make_plane({}, std::cos(std::numbers::pi * share) * axis.v -
                                       std::sin(std::numbers::pi * share) * axis.u);
        drawing.planes.push_back(plane);
        z += lie == Lie::uneven ? 2 + 0.125 * (random() % 24) : 3;  // sums of these are exact
        std::vector<std::uint32_t> seeds;
        for (std::size_t s = 0; s < structures; ++s)
            seeds.push_back(k > 1 && random() % 8 == 0 ? 0 : 1 + random() % 1000000);
        for (std::size_t s = 0; s < structures; ++s)  // a copy of the slice before
            if (k > 1 && random() % 6 == 0) seeds[s] = drawing.seeds.back()[s];
        drawing.seeds.push_back(seeds);
    }
    return drawing;
}

// Stars that change little from slice to slice; some of two parts, or with a hole.
inline void draw(std::uint32_t structure, std::uint32_t seed, SetBuilder& builder) {
    std::mt19937 random(seed);
    const Vec2 middle{6.0 * structure + 0.001 * (random() % 2000), 0.001 * (random() % 2000)};
    switch (random() % 4) {
        case 0:
            builder.ring(structure, star(middle - Vec2{6, 0}, 3, 4, 16, random));
            builder.ring(structure, star(middle + Vec2{6, 0}, 3, 4, 16, random));
            break;
        case 1:
            builder.ring(structure, star(middle, 9, 11, 32, random));
            builder.ring(structure, reversed(star(middle, 3, 4, 16, random)));
            break;
        default:
            builder.ring(structure, star(middle, 9, 11, 32, random));
    }
}

// Two halves of a star with a wall in common.
inline void draw_halves(const std::vector<std::uint32_t>& seeds, SetBuilder& builder) {
    if (seeds[0] == 0 && seeds[1] == 0) return;
    std::mt19937 random(std::max(seeds[0], seeds[1]));
    const Ring whole = star({0.001 * (random() % 2000), 0}, 9, 11, 32, random);
    if (seeds[0] != 0) builder.ring(0, Ring(whole.begin(), whole.begin() + 17));
    if (seeds[1] == 0) return;
    Ring other(whole.begin() + 16, whole.end());
    other.push_back(whole.front());
    builder.ring(1, other);
}

inline ContourSet set_of(const DrawnSlices& drawing) {
    SetBuilder builder(drawing.exclusive);
    for (std::size_t k = 0; k < drawing.planes.size(); ++k) {
        builder.slice(drawing.planes[k]);
        if (drawing.exclusive) {
            draw_halves(drawing.seeds[k], builder);
            continue;
        }
        for (std::uint32_t s = 0; s < drawing.seeds[k].size(); ++s)
            if (drawing.seeds[k][s] != 0) draw(s, drawing.seeds[k][s], builder);
    }
    while (builder.set.structures.size() < drawing.seeds[0].size())
        builder.set.structures.push_back(
            {static_cast<std::int32_t>(builder.set.structures.size()) + 1, "late", {200, 200, 200}});
    return builder.set;
}

inline void edit(DrawnSlices& drawing, std::mt19937& random) {
    const std::size_t slice = random() % drawing.planes.size();
    std::vector<std::uint32_t>& seeds = drawing.seeds[slice];
    std::uint32_t& seed = seeds[random() % seeds.size()];
    switch (random() % 7) {
        case 0:
            if (slice > 1) seed = 0;
            break;
        case 1:
            drawing.planes[slice].origin = drawing.planes[slice].origin + 0.3 * drawing.planes[slice].normal;
            break;
        case 2:
            if (slice > 1 && drawing.planes.size() > 6) {
                drawing.planes.erase(drawing.planes.begin() + static_cast<std::ptrdiff_t>(slice));
                drawing.seeds.erase(drawing.seeds.begin() + static_cast<std::ptrdiff_t>(slice));
            }
            break;
        case 3:  // what one structure had the other one gets
            std::swap(seeds.front(), seeds.back());
            break;
        default:
            seed = 1 + random() % 1000000;
    }
}

}  // namespace anatomesh::fixtures
