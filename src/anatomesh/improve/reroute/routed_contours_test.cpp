#include "anatomesh/improve/reroute/routed_contours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/sample/drawing_for_test.h"

namespace anatomesh::routed_contours_test {
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
struct ReroutedContour {
    ContourSet set = squares(2);
    std::vector<Vec3> points = set.points;
    std::vector<std::uint32_t> vertex_of = std::vector<std::uint32_t>(set.points.size());
    RoutedContour routed{1, {}, 1, 0};

    ReroutedContour() {
        std::iota(vertex_of.begin(), vertex_of.end(), 0u);
        const Contour& contour = set.contours[1];
        routed.vertices.resize(contour.point_count);
        std::iota(routed.vertices.begin(), routed.vertices.end(), contour.first_point);
    }
    std::uint32_t vertex(Vec3 p) const {
        return static_cast<std::uint32_t>(std::find(points.begin(), points.end(), p) - points.begin());
    }
    // A new vertex between two of the contour, which come one after the other, or replace what is between.
    void insert(Vec3 after, Vec3 p) {
        points.push_back(p);
        const auto at = std::find(routed.vertices.begin(), routed.vertices.end(), vertex(after));
        routed.vertices.insert(at + 1, static_cast<std::uint32_t>(points.size() - 1));
    }
    void leave_out(Vec3 p) { std::erase(routed.vertices, vertex(p)); }
    RoutedContourReport report() const {
        return routed_contour_reports(set, vertex_of, std::vector{routed}, points).at(0);
    }
};

TEST(RoutedContours, are_reported_by_how_far_they_go_and_by_what_area) {
    // A triangle of base 1 and height 0.5 on the second side of the square, whichever way the ring goes.
    for (const bool turned : {false, true}) {
        ReroutedContour rerouted;
        const bool forwards = rerouted.routed.vertices[1] == rerouted.vertex({1, 0, 5});
        rerouted.insert(forwards ? Vec3{10, 4, 5} : Vec3{10, 5, 5}, {10.5, 4.5, 5});
        if (turned)
            std::rotate(rerouted.routed.vertices.begin(), rerouted.routed.vertices.begin() + 17,
                        rerouted.routed.vertices.end());
        const RoutedContourReport report = rerouted.report();
        EXPECT_EQ(report.structure, "square");
        EXPECT_EQ(report.slice, "z = 5");
        EXPECT_EQ(report.vertices_left, 0u);
        EXPECT_NEAR(report.farthest_mm, 0.5, 1e-12);
        EXPECT_NEAR(report.difference_mm2, 0.25, 1e-12);
    }
}

TEST(RoutedContours, off_their_plane_are_as_far_away_and_no_area) {
    ReroutedContour rerouted;
    const bool forwards = rerouted.routed.vertices[1] == rerouted.vertex({1, 0, 5});
    rerouted.insert(forwards ? Vec3{10, 4, 5} : Vec3{10, 5, 5}, {10, 4.5, 5.25});
    EXPECT_NEAR(rerouted.report().farthest_mm, 0.25, 1e-12);
    EXPECT_NEAR(rerouted.report().difference_mm2, 0, 1e-12);
}

TEST(RoutedContours, that_pass_a_vertex_by_are_as_far_from_it) {
    ReroutedContour rerouted;
    rerouted.leave_out({10, 10, 5});
    const RoutedContourReport report = rerouted.report();
    EXPECT_EQ(report.vertices_left, 1u);
    EXPECT_NEAR(report.farthest_mm, std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(report.difference_mm2, 0.5, 1e-12);
}

// No common vertex, or common ones in another order: whole rings are compared.
TEST(RoutedContours, of_other_vertices_are_compared_as_a_whole) {
    ReroutedContour rerouted;
    rerouted.routed.vertices.clear();
    for (const Vec3 p : {Vec3{-1, -1, 5}, Vec3{11, -1, 5}, Vec3{11, 11, 5}, Vec3{-1, 11, 5}}) {
        rerouted.points.push_back(p);
        rerouted.routed.vertices.push_back(static_cast<std::uint32_t>(rerouted.points.size() - 1));
    }
    EXPECT_NEAR(rerouted.report().farthest_mm, std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(rerouted.report().difference_mm2, 144 - 100, 1e-9);
    ReroutedContour backwards;
    std::reverse(backwards.routed.vertices.begin(), backwards.routed.vertices.end());
    EXPECT_NEAR(backwards.report().farthest_mm, 0, 1e-12);
    EXPECT_NEAR(backwards.report().difference_mm2, 0, 1e-9);
}

// A vertex that the mesh has lost has a place all the same.
TEST(RoutedContours, may_have_passed_by_a_vertex_that_is_lost) {
    ReroutedContour rerouted;
    rerouted.vertex_of[rerouted.vertex({10, 10, 5})] = no_cell;
    rerouted.leave_out({10, 10, 5});
    EXPECT_EQ(rerouted.report().vertices_left, 1u);
    EXPECT_NEAR(rerouted.report().farthest_mm, std::sqrt(0.5), 1e-12);
}

}  // namespace
}  // namespace anatomesh::routed_contours_test
