#include "anatomesh/improve/sections/facet_worklist.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "anatomesh/improve/sections/sectioned_bricks_for_test.h"

namespace anatomesh::facet_worklist_test {
namespace {

using Visit = std::pair<std::uint32_t, int>;

// Every third cell is suspect; each second visit in turn changes the cells with these numbers.
struct Recorder {
    EditContext& edit;
    std::vector<Visit> visits = {};
    FacetVisit result = FacetVisit::next_facet;
    std::size_t changes_left = 0;

    bool is_suspect(std::uint32_t c) const { return c % 3 == 0; }
    int next_facet(std::uint32_t c, int from) const { return c % 3 == 0 ? from : 4; }
    FacetVisit visit(std::uint32_t c, int i) {
        visits.push_back({c, i});
        if (changes_left == 0) return result;
        --changes_left;
        edit.changed = {c + 1, c + 2, c + 3};
        return FacetVisit::changed;
    }
};

class FacetWorklist : public ::testing::Test {
  protected:
    fixtures::SectionedBricks bricks{1};
    std::vector<std::uint32_t> neighbors = cell_neighbors(bricks.mesh.cells, bricks.mesh.points.size());
    EditMesh mesh{TetMesh(bricks.mesh), neighbors};
    EditContext edit{mesh, bricks.fixed, {}, bricks.field, 2, {}};
    Recorder recorder{edit};
    static bool always() { return true; }
};

TEST_F(FacetWorklist, suspect_cells_are_found_in_order_on_any_number_of_threads) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t c = 0; c < mesh.cell_count(); c += 3) expected.push_back(c);
    EXPECT_EQ(suspect_cells(mesh, recorder, 1), expected);
    EXPECT_EQ(suspect_cells(mesh, recorder, 3), expected);
}

TEST_F(FacetWorklist, all_facets_are_visited_until_one_is_changed_or_the_cell_is_done) {
    std::vector<std::uint32_t> waiting{0, 1, 3};
    visit_facets(edit, waiting, recorder, always);
    EXPECT_EQ(recorder.visits,
              (std::vector<Visit>{{0, 0}, {0, 1}, {0, 2}, {0, 3}, {3, 0}, {3, 1}, {3, 2}, {3, 3}}));
    EXPECT_EQ(waiting.size(), 3u);
    recorder.visits.clear();
    recorder.result = FacetVisit::next_cell;
    visit_facets(edit, waiting, recorder, always);
    EXPECT_EQ(recorder.visits, (std::vector<Visit>{{0, 0}, {3, 0}}));
}

TEST_F(FacetWorklist, changed_cells_that_are_suspect_wait_again) {
    recorder.changes_left = 2;
    recorder.result = FacetVisit::next_cell;
    std::vector<std::uint32_t> waiting{0, 6};
    visit_facets(edit, waiting, recorder, always);
    EXPECT_EQ(waiting, (std::vector<std::uint32_t>{0, 6, 3, 9}));
    EXPECT_EQ(recorder.visits, (std::vector<Visit>{{0, 0}, {6, 0}, {3, 0}, {9, 0}}));
}

TEST_F(FacetWorklist, ends_before_the_next_cell_when_told_so) {
    std::vector<std::uint32_t> waiting{0, 3, 6};
    visit_facets(edit, waiting, recorder, [&] { return recorder.visits.empty(); });
    EXPECT_EQ(recorder.visits.size(), 4u);
}

}  // namespace
}  // namespace anatomesh::facet_worklist_test
