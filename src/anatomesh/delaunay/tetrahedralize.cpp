#include "anatomesh/delaunay/tetrahedralize.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "anatomesh/delaunay/kernel.h"

namespace anatomesh {

namespace {

using KernelCell = DelaunayKernel::KernelCell;

bool finite(Vec3 p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

std::size_t count_distinct(std::span<const Vec3> points) {
    std::vector<Vec3> sorted(points.begin(), points.end());
    std::sort(sorted.begin(), sorted.end(), lexicographic_less);
    return static_cast<std::size_t>(std::unique(sorted.begin(), sorted.end()) - sorted.begin());
}

// The even permutation of a cell that puts its last vertex, by the kernel's numbers, first and the smallest
// of the others second: [i] is where the i-th comes from.
constexpr std::array<std::array<int, 4>, 12> even_permutations{{{0, 1, 2, 3},
                                                                {0, 2, 3, 1},
                                                                {0, 3, 1, 2},
                                                                {1, 0, 3, 2},
                                                                {1, 3, 2, 0},
                                                                {1, 2, 0, 3},
                                                                {2, 3, 0, 1},
                                                                {2, 0, 1, 3},
                                                                {2, 1, 3, 0},
                                                                {3, 2, 1, 0},
                                                                {3, 1, 0, 2},
                                                                {3, 0, 2, 1}}};
const std::array<int, 4>& canonical_places(const std::array<std::uint32_t, 4>& v) {
    int last = 0;  // nearly always: the kernel puts the vertex first that made the cell
    if (v[0] < v[1] || v[0] < v[2] || v[0] < v[3]) {
        last = static_cast<int>(std::max_element(v.begin(), v.end()) - v.begin());
    }
    const auto& p = even_permutations[3 * last];
    const std::uint32_t b = v[p[1]], c = v[p[2]], d = v[p[3]];
    return even_permutations[3 * last + (b < c ? (b < d ? 0 : 2) : (c < d ? 1 : 2))];
}

std::uint32_t last_vertex(const KernelCell& cell) {
    return std::max({cell.vertex[0], cell.vertex[1], cell.vertex[2], cell.vertex[3]});
}

}  // namespace

struct Tetrahedralization::State {
    DelaunayKernel kernel;
    std::vector<Vec3> points;
    std::vector<std::uint32_t> first_vertices;
    std::vector<std::uint32_t> index_of;  // of a kernel's vertex in `points`; no_cell for one not there yet
    std::vector<std::uint32_t> vertices;  // of the last batch, in the kernel
    std::vector<std::uint32_t> slots;     // of the cells of the last snapshot, in its order
    std::vector<std::uint32_t> place_of_slot;  // in the snapshot
    std::uint32_t vertices_then = 0;           // of the kernel, at the last snapshot

    bool insert(std::span<const Vec3> added, int threads, std::vector<std::uint32_t>& result);
    void append_new_cells();
};

// Numbers new vertices in the caller's order; equal points share one.
bool Tetrahedralization::State::insert(std::span<const Vec3> added, int threads,
                                       std::vector<std::uint32_t>& result) {
    if (!kernel.insert(added, threads, vertices)) return false;
    index_of.resize(kernel.vertex_count(), no_cell);
    result.resize(added.size());
    for (std::size_t n = 0; n < added.size(); ++n) {
        std::uint32_t& index = index_of[vertices[n]];
        if (index == no_cell) {
            index = static_cast<std::uint32_t>(points.size());
            points.push_back(added[n]);
        }
        result[n] = index;
    }
    return true;
}

// Appends the slots of the finite cells made since the last snapshot, in canonical order: by their last
// vertex, then by the others.
void Tetrahedralization::State::append_new_cells() {
    const std::span<const KernelCell> cells = kernel.cells();
    const std::uint32_t first = vertices_then, count = kernel.vertex_count() - first;
    const auto is_new = [&](const KernelCell& cell) {
        return cell.alive() && cell.vertex[0] >= first && cell.infinite_place() < 0;
    };
    // Count, scan, fill; then sort the few of one vertex.
    std::vector<std::uint32_t> ends(count + 1, 0);
    for (const KernelCell& cell : cells) {
        if (is_new(cell)) ++ends[last_vertex(cell) - first + 1];
    }
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    struct Entry {
        std::uint32_t b, c, slot;  // the second and the third vertex tell cells of one last vertex apart
    };
    std::vector<Entry> made(ends.back());
    for (std::uint32_t slot = 0; slot < cells.size(); ++slot) {
        if (!is_new(cells[slot])) continue;
        const auto& v = cells[slot].vertex;
        const auto& place = canonical_places(v);
        made[ends[v[place[0]] - first]++] = {v[place[1]], v[place[2]], slot};
    }
    for (std::uint32_t v = 0, begin = 0; v < count; begin = ends[v++]) {
        std::sort(made.begin() + begin, made.begin() + ends[v],
                  [](const Entry& p, const Entry& q) { return p.b != q.b ? p.b < q.b : p.c < q.c; });
    }
    slots.reserve(slots.size() + made.size());
    for (const Entry& entry : made) slots.push_back(entry.slot);
}

Tetrahedralization::Tetrahedralization(std::unique_ptr<State> state) : state_(std::move(state)) {}
Tetrahedralization::Tetrahedralization(Tetrahedralization&&) noexcept = default;
Tetrahedralization& Tetrahedralization::operator=(Tetrahedralization&&) noexcept = default;
Tetrahedralization::~Tetrahedralization() = default;

Result<Tetrahedralization> Tetrahedralization::create(std::span<const Vec3> points, int threads) {
    if (points.size() > most_points) {
        return Error{ErrorKind::limit,
                     "E-DEL-003",
                     std::to_string(points.size()) + " points; at most " + std::to_string(most_points) +
                         " can be tetrahedralized",
                     {},
                     "make the elements larger, or simplify the contours"};
    }
    if (const auto bad = std::find_if_not(points.begin(), points.end(), finite); bad != points.end()) {
        return Error{ErrorKind::geometry,
                     "E-DEL-002",
                     "point " + std::to_string(bad - points.begin()) +
                         " has a coordinate that is infinite or not a number",
                     {},
                     "give finite coordinates in millimetres"};
    }
    Tetrahedralization made(std::make_unique<State>());
    if (!made.state_->insert(points, threads, made.state_->first_vertices)) {
        return Error{ErrorKind::geometry,
                     "E-DEL-001",
                     "the points span no volume: " + std::to_string(count_distinct(points)) +
                         " distinct points, all in one plane",
                     {},
                     "give contours on at least two slices, or a slice with thickness"};
    }
    return made;
}

std::vector<std::uint32_t> Tetrahedralization::insert(std::span<const Vec3> points, int threads) {
    assert(std::all_of(points.begin(), points.end(), finite));
    std::vector<std::uint32_t> vertices;
    state_->insert(points, threads, vertices);
    return vertices;
}

const std::vector<Vec3>& Tetrahedralization::points() const {
    return state_->points;
}

std::span<const std::uint32_t> Tetrahedralization::first_vertices() const {
    return state_->first_vertices;
}

void Tetrahedralization::snapshot(DelaunaySnapshot& snapshot) {
    State& state = *state_;
    const std::span<const KernelCell> cells = state.kernel.cells();
    // Cells that are left of the last snapshot keep their order; a slot used again holds a newer vertex.
    snapshot.previous.clear();
    std::uint32_t kept = 0;
    for (std::uint32_t n = 0; n < state.slots.size(); ++n) {
        const KernelCell& cell = cells[state.slots[n]];
        if (!cell.alive() || cell.vertex[0] >= state.vertices_then) continue;
        state.slots[kept++] = state.slots[n];
        snapshot.previous.push_back(n);
    }
    state.slots.resize(kept);
    state.append_new_cells();
    state.vertices_then = state.kernel.vertex_count();

    const std::size_t count = state.slots.size();
    snapshot.previous.resize(count, no_cell);
    snapshot.cells.resize(count);
    snapshot.neighbors.resize(count);
    state.place_of_slot.assign(cells.size(), no_cell);
    for (std::uint32_t n = 0; n < count; ++n) state.place_of_slot[state.slots[n]] = n;
    for (std::size_t n = 0; n < count; ++n) {
        const KernelCell& cell = cells[state.slots[n]];
        const auto& place = canonical_places(cell.vertex);
        for (int i = 0; i < 4; ++i) {
            snapshot.cells[n][i] = state.index_of[cell.vertex[place[i]]];
            snapshot.neighbors[n][i] = state.place_of_slot[cell.link[place[i]] >> 2];
        }
    }
}

}  // namespace anatomesh
