// Raw contours under construction for tests, and what cleaning makes of them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/overlay/nesting.h"
#include "anatomesh/contour/same_contours_for_test.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh::fixtures {

using Points = std::vector<Vec3>;

// A raw contour file under construction.
struct File {
    RawContours raw;

    File() {
        raw.source = "test";
        raw.structures = {{1, "liver", {}}, {2, "spleen", {}}};
    }
    File& add(const Points& points, std::uint32_t structure = 0,
              ContourKind kind = ContourKind::closed_planar, std::int32_t plane = -1) {
        raw.contours.push_back({structure, kind, static_cast<std::uint32_t>(raw.points.size()),
                                static_cast<std::uint32_t>(points.size()), plane, ""});
        raw.points.insert(raw.points.end(), points.begin(), points.end());
        return *this;
    }
};

inline Points square(double x, double y, double size, double z = 10) {
    return {{x, y, z}, {x + size, y, z}, {x + size, y + size, z}, {x, y + size, z}};
}

inline Points circle(double x, double y, double radius, int count, double z = 10) {
    Points points;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * M_PI * (i + 0.25) / count;
        points.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle), z});
    }
    return points;
}

struct Cleaned {
    Result<CleanResult> result;
    std::vector<Warning> warnings;

    bool ok() const { return result.ok(); }
    const ContourSet& kept() const { return result.value().kept; }
    std::size_t count(const std::string& code) const {
        std::size_t n = 0;
        for (const Warning& warning : warnings) n += warning.code == code;
        return n;
    }
    // The first of a code. Requires: there is one.
    const Warning& warning(const std::string& code) const {
        return *std::find_if(warnings.begin(), warnings.end(),
                             [&](const Warning& each) { return each.code == code; });
    }
    std::string code() const { return result.ok() ? "" : result.error().code; }
    // Area of a structure's region in a slice: holes count negative.
    double area(std::uint32_t slice = 0, std::uint32_t structure = 0) const {
        double sum = 0;
        for (const Contour& contour : kept().contours) {
            if (contour.slice != slice || contour.structure != structure) continue;
            std::vector<Vec2> at;
            for (const Vec3& p : kept().points_of(contour))
                at.push_back(kept().slices[slice].plane.to_plane(p));
            sum += signed_area(at);
        }
        return sum;
    }
};

inline Cleaned clean(const File& file, const CleanOptions& options = {}) {
    RunContext context;
    auto result = clean_contours(file.raw, options, context);
    return {std::move(result), std::move(context.warnings)};
}

// Every invariant of a kept contour set that can be seen from outside, and the promise about shared vertices.
inline void expect_kept(const ContourSet& set) {
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        for (std::uint32_t structure = 0; structure < set.structures.size(); ++structure) {
            std::vector<Ring> rings;
            for (const Contour& contour : set.contours_of(set.slices[s])) {
                EXPECT_EQ(contour.slice, s);
                if (contour.structure != structure) continue;
                const std::span<const Vec3> points = set.points_of(contour);
                EXPECT_GE(points.size(), 3u);
                for (const Vec3& p : points) EXPECT_FALSE(lexicographic_less(p, points[0]));
                rings.push_back(make_ring({points.begin(), points.end()}, set.slices[s].plane, 0));
            }
            const RingEdges edges(rings);
            ASSERT_TRUE(keep_apart(edges, rings));
            const Nesting nesting = nest(edges, rings);
            for (std::size_t r = 0; r < rings.size(); ++r) {
                EXPECT_EQ(signed_area(rings[r].at) > 0, nesting.depth[r] % 2 == 0);
            }
        }
    }
}

}  // namespace anatomesh::fixtures

// Requires: a test body, and using namespace fixtures.
#define EXPECT_KEPT(cleaned)                                              \
    do {                                                                  \
        ASSERT_TRUE((cleaned).ok()) << to_line((cleaned).result.error()); \
        expect_kept((cleaned).kept());                                    \
    } while (false)
