#include "anatomesh/improve/surgery/structure_components.h"

#include <gtest/gtest.h>

#include <array>

#include "anatomesh/improve/sections/sectioned_bricks_for_test.h"

namespace anatomesh::structure_components_test {
namespace {

using fixtures::SectionedBricks;

constexpr std::size_t most_of_component = 6;

struct Counted {
    std::ptrdiff_t all = 0, bare = 0;
    std::vector<std::vector<std::uint32_t>> spurious;
};

// By looking at all cells.
Counted count(EditContext& edit, const ContourOwners& owners, std::uint32_t structure, bool inside,
              std::uint32_t first_new) {
    const EditMesh& mesh = edit.mesh;
    std::vector<std::uint8_t> left(mesh.cell_count(), 0);
    for (const std::uint32_t c : mesh.alive_cells())
        left[c] = edit.table->contains(mesh.region(c), structure) == inside;
    Counted found;
    for (std::uint32_t seed = 0; seed < left.size(); ++seed) {
        if (!left[seed]) continue;
        std::vector<std::uint32_t> cells{seed};
        left[seed] = 0;
        bool drawn = false, fresh = false;
        for (std::size_t n = 0; n < cells.size(); ++n) {
            for (const std::uint32_t v : mesh.cell(cells[n])) {
                drawn = drawn || owners.has(v, structure);
                fresh = fresh || v >= first_new;
            }
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t c = mesh.neighbor(cells[n], i);
                if (c == no_cell || !left[c]) continue;
                left[c] = 0;
                cells.push_back(c);
            }
        }
        ++found.all;
        found.bare += !drawn;
        std::sort(cells.begin(), cells.end());
        if (!drawn && fresh && cells.size() <= most_of_component) found.spurious.push_back(std::move(cells));
    }
    std::sort(found.spurious.begin(), found.spurious.end());
    return found;
}

// One of so many cells is the structure's, at random, and one of so many vertices is of a contour of it.
struct Parts : SectionedBricks {
    Parts(unsigned seed, unsigned one_of, unsigned drawn_every) : SectionedBricks(seed) {
        for (Region& region : mesh.regions) region = random() % one_of == 0 ? 1 : 0;
        std::vector<std::array<std::uint32_t, 2>> drawn;
        for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
            if (random() % drawn_every == 0) drawn.push_back({v, 0});
        }
        owners = ContourOwners(std::move(drawn), mesh.points.size());
    }
};

// Many small parts, few large ones, and some of both; whatever changes, is kept or taken back.
TEST(StructureComponents, their_change_by_an_attempt_is_that_of_all_cells) {
    std::size_t parted = 0, joined = 0, spurious = 0;
    for (unsigned seed = 0; seed < 40; ++seed) {
        Parts parts(seed, 2 + seed % 4, seed % 3 == 0 ? 200 : 20);
        EditMesh edited = parts.editable();
        EditContext edit(edited, parts.fixed, {}, parts.field, 1, {});
        edit.table = &parts.table;
        StructureComponents components(edit, parts.owners, most_of_component);
        for (int attempt = 0; attempt < 20; ++attempt) {
            const auto first_new = static_cast<std::uint32_t>(edited.point_count());
            const auto counted = [&](bool inside) { return count(edit, parts.owners, 0, inside, first_new); };
            const std::array before{counted(false), counted(true)};
            edited.begin_attempt();
            for (auto edits = parts.random() % 12; edits > 0; --edits) parts.change(edit);
            for (const bool inside : {false, true}) {
                const Counted after = counted(inside), &was = before[inside];
                const ComponentChange change = components.change(0, inside, first_new);
                ASSERT_EQ(change.all, after.all - was.all);
                ASSERT_EQ(change.bare, after.bare - was.bare);
                ASSERT_EQ(change.spurious, after.spurious);
                parted += change.all > 0;
                joined += change.all < 0;
                spurious += change.spurious.size();
            }
            edited.end_attempt(parts.random() % 3 == 0);
        }
    }
    EXPECT_GT(parted, 50u);
    EXPECT_GT(joined, 50u);
    EXPECT_GT(spurious, 50u);
}

// A layer of bricks leaves the structure, and parts it in two; what went is a component of the others, bare
// as all are here.
TEST(StructureComponents, a_slab_parts_what_is_on_its_sides) {
    SectionedBricks bricks(1);
    for (Region& region : bricks.mesh.regions) region = 1;
    EditMesh edited = bricks.editable();
    EditContext edit(edited, bricks.fixed, {}, bricks.field, 1, {});
    edit.table = &bricks.table;
    StructureComponents components(edit, bricks.owners, most_of_component);
    const auto first_new = static_cast<std::uint32_t>(edited.point_count());
    edited.begin_attempt();
    EXPECT_EQ(components.change(0, true, first_new), ComponentChange{});
    // Bricks have six cells each, one after the other, layer by layer.
    constexpr std::uint32_t cells_a_layer = 6 * SectionedBricks::width * SectionedBricks::width;
    for (const std::uint32_t c : edited.alive_cells()) {
        if (c / cells_a_layer == 3) edited.set_region(c, 0);
    }
    for (const bool inside : {false, true})
        EXPECT_EQ(components.change(0, inside, first_new), (ComponentChange{1, 1, {}}));
    edited.end_attempt(false);
}

}  // namespace
}  // namespace anatomesh::structure_components_test
