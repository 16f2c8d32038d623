#include "anatomesh/improve/sections/section_areas.h"

#include <gtest/gtest.h>

#include <numeric>

#include "anatomesh/improve/sections/sectioned_bricks_for_test.h"

namespace anatomesh::section_areas_test {
namespace {

using fixtures::SectionedBricks;

// Levels in a stack and sides of single planes are two ways to the same answers.
TEST(SectionAreas, parallel_planes_are_as_planes_in_any_position) {
    std::size_t passed = 0, lying = 0;
    for (unsigned seed = 0; seed < 10; ++seed) {
        SectionedBricks bricks(seed);
        const DrawnSlices parallel = bricks.drawn();
        EditMesh edited = bricks.editable();
        EditContext edit(edited, bricks.fixed, {}, bricks.field, 2, {});
        SectionAreas stack(edit, parallel);
        bricks.give_extents();
        const DrawnSlices any = bricks.drawn();
        SectionAreas single(edit, any);
        const std::vector<std::uint32_t> all = edited.alive_cells();
        for (const std::uint32_t c : all) {
            const Cell& cell = edited.cell(c);
            for (const std::uint32_t v : cell) {
                for (std::uint32_t k = 0; k < bricks.planes.size(); ++k)
                    ASSERT_EQ(stack.side(v, k), single.side(v, k));
            }
            for (int i = 0; i < 4; ++i) {
                const auto [a, b, d] = facet_vertices[i];
                const std::array facet{cell[a], cell[b], cell[d]};
                ASSERT_EQ(stack.passes_between(facet), single.passes_between(facet));
                ASSERT_EQ(stack.plane_of(facet), single.plane_of(facet));
                passed += stack.passes_between(facet);
                lying += stack.plane_of(facet) != no_slice;
            }
        }
        stack.sum_cuts(all);
        single.sum_cuts(all);
        for (std::size_t n = 0; n < bricks.weights.size(); ++n)
            ASSERT_NEAR(stack.sums()[n], single.sums()[n], 1e-12);
    }
    EXPECT_GT(passed, 100u);
    EXPECT_GT(lying, 100u);
}

// What is wrong in the cross-sections together is what is wrong in the cells together.
TEST(SectionAreas, sums_of_cross_sections_add_up_to_what_is_wrong_in_all_cells) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        SectionedBricks bricks(seed);
        if (seed % 2) bricks.give_extents();
        const DrawnSlices drawn = bricks.drawn();
        EditMesh edited = bricks.editable();
        EditContext edit(edited, bricks.fixed, {}, bricks.field, 2, {});
        SectionAreas areas(edit, drawn);
        const std::vector<std::uint32_t> all = edited.alive_cells();
        areas.sum_cuts(all);
        const double sum = std::accumulate(areas.sums().begin(), areas.sums().end(), 0.0);
        EXPECT_GT(sum, 1);
        EXPECT_NEAR(sum, areas.wrong(all), 1e-9 * sum);
    }
}

// Sums and sections found by several threads in pieces: so many cells that there are several of these.
TEST(SectionAreas, any_threads_find_the_same) {
    SectionedBricks bricks(2);
    const DrawnSlices drawn = bricks.drawn();
    EditMesh edited = bricks.editable();
    EditContext edit(edited, bricks.fixed, {}, bricks.field, 2, {});
    SectionAreas areas(edit, drawn);
    const std::vector<std::uint32_t> once = edited.alive_cells();
    std::vector<std::uint32_t> all;
    for (int n = 0; n < 30; ++n) all.insert(all.end(), once.begin(), once.end());
    ASSERT_GT(all.size(), 20'000u);
    areas.sum_cuts(all);
    const std::vector<double> sums(areas.sums().begin(), areas.sums().end());
    const auto errors = areas.errors_of(all);
    EXPECT_GT(errors.size(), 1000u);
    for (const int threads : {2, 3}) {
        areas.sum_cuts(all, threads);
        EXPECT_EQ(std::vector<double>(areas.sums().begin(), areas.sums().end()), sums);
        EXPECT_EQ(areas.errors_of(all, threads), errors);
        for (std::uint32_t k = 0; k < bricks.planes.size(); ++k) {
            const auto one = areas.wrong_sections_of(0, k, all),
                       several = areas.wrong_sections_of(0, k, all, threads);
            ASSERT_EQ(one.size(), several.size());
            for (std::size_t n = 0; n < one.size(); ++n) {
                ASSERT_EQ(one[n].cell, several[n].cell);
                ASSERT_EQ(one[n].facet, several[n].facet);
                ASSERT_EQ(one[n].share, several[n].share);
            }
        }
    }
}

// A structure's wrong sections by a plane are what the cross-section has wrong in all.
TEST(SectionAreas, wrong_sections_of_a_plane_add_up_to_its_cross_section) {
    std::size_t facets = 0;
    for (unsigned seed = 0; seed < 6; ++seed) {
        SectionedBricks bricks(seed);
        if (seed % 2) bricks.give_extents();
        const DrawnSlices drawn = bricks.drawn();
        EditMesh edited = bricks.editable();
        EditContext edit(edited, bricks.fixed, {}, bricks.field, 2, {});
        SectionAreas areas(edit, drawn);
        const std::vector<std::uint32_t> all = edited.alive_cells();
        areas.sum_cuts(all);
        for (std::uint32_t s = 0; s < 2; ++s) {
            for (std::uint32_t k = 0; k < bricks.planes.size(); ++k) {
                double sum = 0;
                for (const SectionAreas::Section& section : areas.wrong_sections_of(s, k, all)) {
                    sum += section.share;
                    facets += section.facet < 4;
                }
                EXPECT_NEAR(sum, areas.sums()[s * bricks.planes.size() + k], 1e-3);
            }
        }
    }
    EXPECT_GT(facets, 100u);
}

}  // namespace
}  // namespace anatomesh::section_areas_test
