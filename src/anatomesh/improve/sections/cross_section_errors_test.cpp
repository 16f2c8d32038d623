#include "anatomesh/improve/sections/cross_section_errors.h"

#include <gtest/gtest.h>

#include "anatomesh/improve/sections/sectioned_bricks_for_test.h"

namespace anatomesh::cross_section_errors_test {
namespace {

using fixtures::SectionedBricks;

std::vector<double> whole_sums(SectionAreas& areas, const EditMesh& mesh) {
    areas.sum_cuts(mesh.alive_cells());
    return {areas.sums().begin(), areas.sums().end()};
}

std::vector<double> list(std::span<const double> sums) {
    return {sums.begin(), sums.end()};
}

// To the last bit, whatever changes, is kept or taken back.
TEST(CrossSectionErrors, sums_kept_up_to_date_are_those_of_all_cells) {
    std::size_t kept = 0, changed_sums = 0;
    for (unsigned seed = 0; seed < 12; ++seed) {
        SectionedBricks bricks(seed);
        if (seed % 3 == 0) bricks.give_extents();
        const DrawnSlices drawn = bricks.drawn();
        EditMesh edited = bricks.editable();
        EditContext edit(edited, bricks.fixed, {}, bricks.field, 2, {});
        SectionAreas areas(edit, drawn);
        CrossSectionErrors errors(edit, areas, edited.alive_cells());
        ASSERT_EQ(list(errors.sums()), whole_sums(areas, edited));
        for (int attempt = 0; attempt < 25; ++attempt) {
            const std::vector<double> before = list(errors.sums());
            edited.begin_attempt();
            for (auto edits = bricks.random() % 8; edits > 0; --edits) bricks.change(edit);
            const std::vector<double> after = list(errors.sums_after(edited.changed_cells()));
            ASSERT_EQ(after, whole_sums(areas, edited));
            ASSERT_EQ(list(errors.sums()), before);
            changed_sums += after != before;
            const bool keep = bricks.random() % 2 == 0;
            edited.end_attempt(keep);
            if (keep) errors.keep();
            kept += keep;
            ASSERT_EQ(list(errors.sums()), whole_sums(areas, edited));
        }
    }
    EXPECT_GT(kept, 100u);
    EXPECT_GT(changed_sums, 100u);
}

// Asked several times in one attempt, as more and more changes.
TEST(CrossSectionErrors, sums_of_an_attempt_follow_each_of_its_changes) {
    SectionedBricks bricks(3);
    const DrawnSlices drawn = bricks.drawn();
    EditMesh edited = bricks.editable();
    EditContext edit(edited, bricks.fixed, {}, bricks.field, 2, {});
    SectionAreas areas(edit, drawn);
    CrossSectionErrors errors(edit, areas, edited.alive_cells());
    edited.begin_attempt();
    for (int n = 0; n < 30; ++n) {
        bricks.change(edit);
        ASSERT_EQ(list(errors.sums_after(edited.changed_cells())), whole_sums(areas, edited));
    }
    edited.end_attempt(false);
    EXPECT_EQ(list(errors.sums()), whole_sums(areas, edited));
}

TEST(CrossSectionErrors, some_cells_and_then_the_others_are_all) {
    SectionedBricks bricks(5);
    const DrawnSlices drawn = bricks.drawn();
    EditMesh edited = bricks.editable();
    EditContext edit(edited, bricks.fixed, {}, bricks.field, 2, {});
    SectionAreas areas(edit, drawn);
    for (const std::uint32_t every : {1u, 2u, 7u, 100'000u}) {
        std::vector<std::uint32_t> some;
        for (const std::uint32_t c : edited.alive_cells()) {
            if (c % every == 0) some.push_back(c);
        }
        CrossSectionErrors errors(edit, areas, some);
        areas.sum_cuts(some);
        ASSERT_EQ(list(errors.sums()), list(areas.sums()));
        for (const int threads : {1, 3}) {
            CrossSectionErrors all = errors;
            all.add_others(some, threads);
            ASSERT_EQ(list(all.sums()), whole_sums(areas, edited));
        }
    }
}

}  // namespace
}  // namespace anatomesh::cross_section_errors_test
