#include "anatomesh/improve/core/edit_constraints.h"

#include <gtest/gtest.h>

#include <array>

namespace anatomesh::edit_constraints_test {
namespace {

// Vertices 0 to 3 are fixed and edge 01 is; vertices 4 and 5 are free.
struct Fixture {
    std::vector<std::uint8_t> fixed{1, 1, 1, 1, 0, 0};
    std::vector<VertexPair> edges{{0, 1}};
    EditConstraints constraints{fixed, edges};
};

TEST(EditConstraints, vertices_are_free_fixed_or_settled) {
    Fixture f;
    f.constraints.settle(4);
    EXPECT_TRUE(f.constraints.fixed(4));
    EXPECT_TRUE(f.constraints.settled(4));
    f.constraints.fix(4);
    EXPECT_TRUE(f.constraints.fixed(4));
    EXPECT_FALSE(f.constraints.settled(4));
    f.constraints.unfix(4);
    EXPECT_FALSE(f.constraints.fixed(4));
    f.constraints.add_free_vertex();
    EXPECT_EQ(f.fixed.size(), 7u);
    EXPECT_FALSE(f.constraints.fixed(6));
}

TEST(EditConstraints, an_edge_is_fixed_in_both_directions_while_its_ends_are) {
    Fixture f;
    EXPECT_TRUE(f.constraints.fixed_edge(0, 1));
    EXPECT_TRUE(f.constraints.fixed_edge(1, 0));
    EXPECT_FALSE(f.constraints.fixed_edge(0, 2));
    f.constraints.unfix(1);
    EXPECT_FALSE(f.constraints.fixed_edge(0, 1));
}

TEST(EditConstraints, each_unfix_takes_one_fix_of_an_edge_back) {
    Fixture f;
    f.constraints.fix_edge(3, 2);
    f.constraints.fix_edge(2, 3);
    f.constraints.unfix_edge(3, 2);
    EXPECT_TRUE(f.constraints.fixed_edge(2, 3));
    f.constraints.unfix_edge(2, 3);
    EXPECT_FALSE(f.constraints.fixed_edge(2, 3));
    f.constraints.unfix_edge(2, 3);
    f.constraints.unfix_edge(0, 1);  // one of those given stays
    EXPECT_TRUE(f.constraints.fixed_edge(0, 1));
}

TEST(EditConstraints, a_kept_edge_is_lost_with_the_last_cell_that_has_it) {
    Fixture f;
    const Cell removed{0, 2, 4, 5};
    const std::array<Cell, 2> with{{{1, 3, 4, 5}, {2, 4, 0, 3}}}, without{{{1, 3, 4, 5}, {2, 4, 1, 3}}};
    EXPECT_FALSE(f.constraints.keeps_any_edge());
    f.constraints.keep_edge(2, 0);
    f.constraints.keep_edge(0, 2);
    EXPECT_TRUE(f.constraints.keeps_any_edge());
    EXPECT_TRUE(f.constraints.keeps_edge(0, 2));
    EXPECT_FALSE(f.constraints.loses_kept_edge(removed, with));
    EXPECT_TRUE(f.constraints.loses_kept_edge(removed, without));
    f.constraints.release_edge(2, 0);
    EXPECT_FALSE(f.constraints.keeps_any_edge());
    EXPECT_FALSE(f.constraints.loses_kept_edge(removed, without));
}

TEST(SliceVertices, drawn_vertices_and_those_added_have_a_slice) {
    const std::array<std::uint32_t, 3> drawn{7, no_slice, 8};
    SliceVertices vertices;
    vertices.add(4, 7);
    vertices.add(6, 9);
    EXPECT_EQ(vertices.slice_of(0, drawn), 7u);
    EXPECT_EQ(vertices.slice_of(1, drawn), no_slice);
    EXPECT_EQ(vertices.slice_of(3, drawn), no_slice);
    EXPECT_EQ(vertices.slice_of(4, drawn), 7u);
    EXPECT_EQ(vertices.slice_of(5, drawn), no_slice);
    EXPECT_EQ(vertices.slice_of(6, drawn), 9u);
    EXPECT_EQ(vertices.slice_of(7, drawn), no_slice);
}

}  // namespace
}  // namespace anatomesh::edit_constraints_test
