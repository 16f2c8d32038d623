#include "anatomesh/improve/reroute/followed_contours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "anatomesh/sample/drawing_for_test.h"

namespace anatomesh {
namespace {

// Squares of side 10 on planes z = 0, 5, ..., drawn with a vertex every millimetre.
ContourSet squares(int slices) {
    RawContours raw;
    raw.structures.push_back({1, "square", {}});
    for (int k = 0; k < slices; ++k) {
        raw.planes.push_back(make_plane({0, 0, 5.0 * k}, {0, 0, 1}));
        raw.plane_names.push_back("z = " + std::to_string(5 * k));
        RawContour contour;
        contour.plane = k;
        contour.first_point = static_cast<std::uint32_t>(raw.points.size());
        for (const auto& [from, way] :
             {std::pair{Vec3{0, 0, 0}, Vec3{1, 0, 0}}, std::pair{Vec3{10, 0, 0}, Vec3{0, 1, 0}},
              std::pair{Vec3{10, 10, 0}, Vec3{-1, 0, 0}}, std::pair{Vec3{0, 10, 0}, Vec3{0, -1, 0}}}) {
            for (int n = 0; n < 10; ++n) raw.points.push_back(Vec3{0, 0, 5.0 * k} + from + n * way);
        }
        contour.point_count = 40;
        raw.contours.push_back(contour);
    }
    return fixtures::kept(raw);
}

// A mesh of the contours' points and others.
struct Led {
    ContourSet set = squares(2);
    std::vector<Vec3> points = set.points;
    std::vector<std::uint32_t> vertex_of = std::vector<std::uint32_t>(set.points.size());
    FollowedContour followed{1, {}, 1, 0};

    Led() {
        std::iota(vertex_of.begin(), vertex_of.end(), 0u);
        const Contour& contour = set.contours[1];
        followed.vertices.resize(contour.point_count);
        std::iota(followed.vertices.begin(), followed.vertices.end(), contour.first_point);
    }
    std::uint32_t vertex(Vec3 p) const {
        return static_cast<std::uint32_t>(std::find(points.begin(), points.end(), p) - points.begin());
    }
    // A new vertex between two of the contour, which come one after the other, or replace what is between.
    void insert(Vec3 after, Vec3 p) {
        points.push_back(p);
        const auto at = std::find(followed.vertices.begin(), followed.vertices.end(), vertex(after));
        followed.vertices.insert(at + 1, static_cast<std::uint32_t>(points.size() - 1));
    }
    void leave_out(Vec3 p) { std::erase(followed.vertices, vertex(p)); }
    FollowedContourReport report() const {
        return followed_contours(set, vertex_of, std::vector{followed}, points).at(0);
    }
};

TEST(FollowedContours, are_reported_by_how_far_they_go_and_by_what_area) {
    // A triangle of base 1 and height 0.5 on the second side of the square, whichever way the ring goes.
    for (const bool turned : {false, true}) {
        Led led;
        const bool forwards = led.followed.vertices[1] == led.vertex({1, 0, 5});
        led.insert(forwards ? Vec3{10, 4, 5} : Vec3{10, 5, 5}, {10.5, 4.5, 5});
        if (turned)
            std::rotate(led.followed.vertices.begin(), led.followed.vertices.begin() + 17,
                        led.followed.vertices.end());
        const FollowedContourReport report = led.report();
        EXPECT_EQ(report.structure, "square");
        EXPECT_EQ(report.slice, "z = 5");
        EXPECT_EQ(report.vertices_left, 0u);
        EXPECT_NEAR(report.farthest_mm, 0.5, 1e-12);
        EXPECT_NEAR(report.difference_mm2, 0.25, 1e-12);
    }
}

TEST(FollowedContours, off_their_plane_are_as_far_away_and_no_area) {
    Led led;
    const bool forwards = led.followed.vertices[1] == led.vertex({1, 0, 5});
    led.insert(forwards ? Vec3{10, 4, 5} : Vec3{10, 5, 5}, {10, 4.5, 5.25});
    EXPECT_NEAR(led.report().farthest_mm, 0.25, 1e-12);
    EXPECT_NEAR(led.report().difference_mm2, 0, 1e-12);
}

TEST(FollowedContours, that_pass_a_vertex_by_are_as_far_from_it) {
    Led led;
    led.leave_out({10, 10, 5});
    const FollowedContourReport report = led.report();
    EXPECT_EQ(report.vertices_left, 1u);
    EXPECT_NEAR(report.farthest_mm, std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(report.difference_mm2, 0.5, 1e-12);
}

// No common vertex, or common ones in another order: whole rings are compared.
TEST(FollowedContours, of_other_vertices_are_compared_as_a_whole) {
    Led led;
    led.followed.vertices.clear();
    for (const Vec3 p : {Vec3{-1, -1, 5}, Vec3{11, -1, 5}, Vec3{11, 11, 5}, Vec3{-1, 11, 5}}) {
        led.points.push_back(p);
        led.followed.vertices.push_back(static_cast<std::uint32_t>(led.points.size() - 1));
    }
    EXPECT_NEAR(led.report().farthest_mm, std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(led.report().difference_mm2, 144 - 100, 1e-9);
    Led backwards;
    std::reverse(backwards.followed.vertices.begin(), backwards.followed.vertices.end());
    EXPECT_NEAR(backwards.report().farthest_mm, 0, 1e-12);
    EXPECT_NEAR(backwards.report().difference_mm2, 0, 1e-9);
}

// A vertex that the mesh has lost has a place all the same.
TEST(FollowedContours, may_have_passed_by_a_vertex_that_is_lost) {
    Led led;
    led.vertex_of[led.vertex({10, 10, 5})] = no_cell;
    led.leave_out({10, 10, 5});
    EXPECT_EQ(led.report().vertices_left, 1u);
    EXPECT_NEAR(led.report().farthest_mm, std::sqrt(0.5), 1e-12);
}

}  // namespace
}  // namespace anatomesh
