#include "anatomesh/improve/surgery/remove_spikes.h"

#include <cmath>
#include <numbers>

#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::remove_spikes_test {
namespace {

using namespace fixtures;

const double ten_degrees = std::sin(10 * std::numbers::pi / 180);

struct Removed {
    TetMesh mesh;
    SpikeStats stats;
    std::vector<std::uint8_t> fixed;
};

Removed removed(const LabelledCase& c, double spike_mm, int threads = 1) {
    std::vector<std::uint8_t> fixed = c.fixed;
    EditMesh mesh(c.mesh, cell_neighbors(c.mesh.cells, c.mesh.points.size()));
    EditContext edit(mesh, fixed, {}, c.field, c.structures, {});
    edit.table = &c.regions;
    const SpikeStats stats = remove_spikes(edit, spike_mm, ten_degrees, threads);
    std::vector<std::uint32_t> neighbors;
    TetMesh taken = std::move(mesh).take(neighbors);
    EXPECT_EQ(neighbors, cell_neighbors(taken.cells, taken.points.size()));
    return {std::move(taken), stats, fixed};
}

// Of all structures' surfaces: how far each vertex is from its own in the field, those above `beyond` added
// up.
double far_off(const TetMesh& mesh, const LabelledCase& c, double beyond) {
    double sum = 0;
    for (std::uint32_t s = 0; s < c.structures; ++s) {
        const auto on = on_surface(mesh, c.regions, s);
        for (std::size_t v = 0; v < on.size(); ++v) {
            const double distance = on[v] ? std::abs(c.field.value(s, mesh.points[v])) : 0;
            if (distance > beyond) sum += distance;
        }
    }
    return sum;
}

TEST(RemoveSpikes, surfaces_come_nearer_to_the_field_and_stay_what_they_are) {
    std::uint64_t lowered_in_all = 0;
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        for (const double spike_mm : {0.3, 0.8}) {
            const Removed done = removed(c, spike_mm);
            expect_sound_mesh(done.mesh, c.mesh);
            expect_same_surfaces(done.mesh, c.mesh, c.regions, c.structures);
            expect_sound_regions(done.mesh, c.regions);
            EXPECT_LE(done.stats.removed, done.stats.found);
            lowered_in_all += done.stats.removed;
            // Every point is where it was, and what is fixed is on the surfaces that it was on if it lies
            // there.
            ASSERT_TRUE(std::equal(c.mesh.points.begin(), c.mesh.points.end(), done.mesh.points.begin()));
            ASSERT_EQ(done.fixed.size(), done.mesh.points.size());
            for (std::uint32_t s = 0; s < c.structures; ++s) {
                const auto before = on_surface(c.mesh, c.regions, s),
                           after = on_surface(done.mesh, c.regions, s);
                for (std::size_t v = 0; v < before.size(); ++v) {
                    const bool near = std::abs(c.field.value(s, c.mesh.points[v])) <= spike_mm;
                    EXPECT_TRUE(near ? before[v] == after[v] : before[v] >= after[v]) << v;
                }
            }
            // No cell is worse than what is asked of new ones, or than the worst there was.
            EXPECT_GE(worst_sine(done.mesh), std::min(worst_sine(c.mesh), ten_degrees));
            EXPECT_LE(worst_ratio(done.mesh),
                      std::max(worst_ratio(c.mesh), MeshImprovementOptions{}.last_radius_edge));
            if (done.stats.removed == 0) continue;
            EXPECT_LT(far_off(done.mesh, c, spike_mm), far_off(c.mesh, c, spike_mm));
        }
    }
    EXPECT_GT(lowered_in_all, 100u);
}

TEST(RemoveSpikes, the_same_for_any_number_of_threads) {
    for (const LabelledCase& c : labelled_cases()) {
        const Removed one = removed(c, 0.3), four = removed(c, 0.3, 4);
        EXPECT_EQ(one.mesh.points, four.mesh.points);
        EXPECT_EQ(one.mesh.cells, four.mesh.cells);
        EXPECT_EQ(one.mesh.regions, four.mesh.regions);
    }
}

// A cell beside the surface of a ball, the fourth vertex of which is off it, goes to the other side.
std::vector<std::uint32_t> make_spikes(LabelledCase& c, Region taken) {
    const auto on = on_surface(c.mesh, c.regions, 0);
    const std::vector<std::uint32_t> neighbors = cell_neighbors(c.mesh.cells, c.mesh.points.size());
    std::vector<std::uint8_t> touched(c.mesh.points.size(), 0);
    std::vector<std::uint32_t> spikes, cells;
    for (std::uint32_t cell = 0; cell < c.mesh.cells.size(); ++cell) {
        const Cell& v = c.mesh.cells[cell];
        if (c.mesh.regions[cell] != taken || sine_of(c.mesh, v) < 0.4 ||
            std::any_of(v.begin(), v.end(), [&](std::uint32_t p) { return touched[p] != 0; }))
            continue;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t n = neighbors[4 * std::size_t{cell} + i];
            if (n == no_cell || c.mesh.regions[n] == taken || on[v[i]]) continue;
            for (const std::uint32_t p : v) touched[p] = 1;
            spikes.push_back(v[i]);
            cells.push_back(cell);
            break;
        }
    }
    for (const std::uint32_t cell : cells) c.mesh.regions[cell] = taken == 0 ? Region{1} : Region{0};
    c.fixed = on;
    return spikes;
}

TEST(RemoveSpikes, a_cell_that_stands_on_fixed_vertices_is_cut_off_near_them) {
    for (const Region taken : {Region{0}, Region{1}}) {
        LabelledCase c = sampled_case("ball", AnalyticField({ball({}, 6)}, 7), 1, 1'000'000);
        const std::vector<std::uint32_t> spikes = make_spikes(c, taken);
        ASSERT_GT(spikes.size(), 8u);
        const Removed done = removed(c, 0.2);
        EXPECT_GE(done.stats.removed, spikes.size() * 3 / 4);
        expect_same_surfaces(done.mesh, c.mesh, c.regions, 1);
        const auto after = on_surface(done.mesh, c.regions, 0);
        EXPECT_LE(std::count_if(spikes.begin(), spikes.end(), [&](std::uint32_t v) { return after[v] != 0; }),
                  static_cast<std::ptrdiff_t>(spikes.size() / 4));
        EXPECT_LT(far_off(done.mesh, c, 0.3), 0.3 * far_off(c.mesh, c, 0.3));
    }
}

// Two slabs with a gap; cells of the upper one reach over it to fixed vertices of the lower one's surface.
// These leave the upper one's surface and stay on their own.
TEST(RemoveSpikes, a_cell_that_reaches_a_fixed_vertex_of_another_structure_lets_go_of_it) {
    const auto lower = [](Vec3 p) { return p.z - 2; };
    const auto upper = [](Vec3 p) { return 3 - p.z; };
    LabelledCase c{"slabs", AnalyticField({lower, upper}, 9, true), 2, {}, RegionTable{{{}, {0}, {1}}}, {}};
    c.mesh = testing::brick_mesh({7, 7, 5}, [](int, int, int) { return Region{1}; });
    std::uint32_t reaching = 0;
    std::vector<std::uint32_t> spikes;
    for (std::size_t n = 0; n < c.mesh.cells.size(); ++n) {
        const Cell& cell = c.mesh.cells[n];
        Vec3 middle;
        for (const std::uint32_t v : cell) middle += 0.25 * c.mesh.points[v];
        c.mesh.regions[n] = middle.z < 2 ? Region{1} : middle.z > 3 ? Region{2} : Region{0};
        std::vector<std::uint32_t> low;
        for (const std::uint32_t v : cell) {
            if (c.mesh.points[v].z == 2) low.push_back(v);
        }
        const auto inner = [](double x) { return x == 2 || x == 4 || x == 5; };
        // Three corners in the upper one's surface, one in the lower one's.
        if (middle.z < 2 || middle.z > 3 || low.size() != 1 || reaching > 20) continue;
        const Vec3 p = c.mesh.points[low[0]];
        if (!inner(p.x) || !inner(p.y) || std::find(spikes.begin(), spikes.end(), low[0]) != spikes.end())
            continue;
        c.mesh.regions[n] = 2;
        spikes.push_back(low[0]);
        ++reaching;
    }
    ASSERT_EQ(spikes.size(), 9u);
    c.fixed.assign(c.mesh.points.size(), 1);
    for (const std::uint32_t v : spikes) EXPECT_TRUE(on_surface(c.mesh, c.regions, 1)[v]);
    const Removed done = removed(c, 0.5);
    EXPECT_EQ(done.stats.removed, spikes.size());
    expect_sound_mesh(done.mesh, c.mesh);
    expect_same_surfaces(done.mesh, c.mesh, c.regions, 2);
    expect_sound_regions(done.mesh, c.regions);
    EXPECT_EQ(structure_surface(done.mesh, c.regions, 0).size(),
              structure_surface(c.mesh, c.regions, 0).size());
    for (const std::uint32_t v : spikes) {
        EXPECT_TRUE(on_surface(done.mesh, c.regions, 0)[v]);
        EXPECT_FALSE(on_surface(done.mesh, c.regions, 1)[v]);
    }
}

}  // namespace
}  // namespace anatomesh::remove_spikes_test
