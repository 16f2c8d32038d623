#include "anatomesh/delaunay/tetrahedralize.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/delaunay/kernel.h"

namespace anatomesh {

namespace {

using KernelCell = DelaunayKernel::KernelCell;

constexpr std::size_t ahead =
    6;  // Cells are fetched into the cache so many before they are read. [cells; >= 0; B]

bool finite(Vec3 p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

std::size_t count_distinct(std::span<const Vec3> points) {
    std::vector<Vec3> sorted(points.begin(), points.end());
    std::sort(sorted.begin(), sorted.end(), LexicographicLess{});
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

}  // namespace

struct Tetrahedralization::State {
    DelaunayKernel kernel;
    std::vector<Vec3> points;
    std::vector<std::uint32_t> first_vertices;
    std::vector<std::uint32_t> index_of;  // of a kernel's vertex in `points`; no_cell for one not there yet
    std::vector<std::uint32_t> vertices;  // of the last batch, in the kernel
    DelaunaySnapshot snapshot;
    std::vector<std::uint32_t> slots;  // of the cells of the snapshot
    std::vector<std::uint32_t>
        place_of_slot;                // in the snapshot; no_cell for a slot without a finite cell there
    std::uint32_t vertices_then = 0;  // of the kernel, at the snapshot

    bool insert(std::span<const Vec3> added, int threads, std::vector<std::uint32_t>& result);
    std::vector<std::uint32_t> take_removed_places(std::span<const std::uint32_t> touched);
    std::vector<std::uint32_t> new_cells(std::span<const std::uint32_t> touched, int threads);
    void put(std::uint32_t slot, std::uint32_t place);
    void fill_from_the_end(std::span<const std::uint32_t> holes);
    void write_changed(int threads);
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

// The places of cells that are gone, rising.
std::vector<std::uint32_t> Tetrahedralization::State::take_removed_places(
    std::span<const std::uint32_t> touched) {
    std::vector<std::uint32_t> places;
    for (const std::uint32_t slot : touched) {
        std::uint32_t& place = place_of_slot[slot];
        if (place == no_cell) continue;
        places.push_back(place);
        place = no_cell;
    }
    sort_distinct(places, slots.size());
    return places;
}

// The slots of the finite cells made since the snapshot, in canonical order: by their last vertex, then by
// the others. A slot may be touched several times; none of those touched has a place.
std::vector<std::uint32_t> Tetrahedralization::State::new_cells(std::span<const std::uint32_t> touched,
                                                                int threads) {
    const std::span<const KernelCell> cells = kernel.cells();
    const std::uint32_t first = vertices_then, count = kernel.vertex_count() - first;
    struct Entry {
        std::uint32_t last, b, c,
            slot;  // the second and the third vertex tell cells of one last vertex apart
    };
    const std::vector<Entry> made = parallel_collect<Entry>(
        touched.size(), 4096, threads, [&](std::size_t begin, std::size_t end, std::vector<Entry>& out) {
            for (std::size_t n = begin; n < end; ++n) {
                if (n + ahead < end) __builtin_prefetch(&cells[touched[n + ahead]]);
                const KernelCell& cell = cells[touched[n]];
                if (!cell.alive() || cell.infinite_place() >= 0) continue;
                const auto& v = cell.vertex;
                const auto& place = canonical_places(v);
                out.push_back({v[place[0]] - first, v[place[1]], v[place[2]], touched[n]});
            }
        });
    // Count, scan, fill; then sort the few of one vertex.
    std::vector<std::uint32_t> ends(count + 1, 0);
    for (const Entry& entry : made) ++ends[entry.last + 1];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<Entry> entries(made.size());
    for (const Entry& entry : made) entries[ends[entry.last]++] = entry;
    parallel_for(count, 4096, threads, [&](std::size_t first_vertex, std::size_t last_vertex) {
        for (std::size_t v = first_vertex; v < last_vertex; ++v) {
            std::sort(entries.begin() + (v > 0 ? ends[v - 1] : 0), entries.begin() + ends[v],
                      [](const Entry& p, const Entry& q) { return p.b != q.b ? p.b < q.b : p.c < q.c; });
        }
    });
    std::vector<std::uint32_t> slots_made;
    slots_made.reserve(entries.size());
    for (const Entry& entry : entries) {
        if (slots_made.empty() || slots_made.back() != entry.slot) slots_made.push_back(entry.slot);
    }
    return slots_made;
}

void Tetrahedralization::State::put(std::uint32_t slot, std::uint32_t place) {
    if (place == slots.size()) slots.emplace_back();
    slots[place] = slot;
    place_of_slot[slot] = place;
    snapshot.changed.push_back(place);
}

// Moves the last cells into the holes, which rise.
void Tetrahedralization::State::fill_from_the_end(std::span<const std::uint32_t> holes) {
    const std::size_t size = slots.size() - holes.size();
    std::size_t last = slots.size(), last_hole = holes.size();
    for (const std::uint32_t hole : holes) {
        if (hole >= size) break;
        for (--last; holes[last_hole - 1] == last; --last) --last_hole;
        put(slots[last], hole);
    }
    slots.resize(size);
}

// The arrays at the changed places, and the links to these of older cells round them.
void Tetrahedralization::State::write_changed(int threads) {
    const std::span<const KernelCell> cells = kernel.cells();
    if (snapshot.cells.empty()) {  // with room for what refinement adds
        snapshot.cells.reserve(2 * slots.size());
        snapshot.neighbors.reserve(2 * slots.size());
    }
    parallel_tasks(threads, {[&] { snapshot.cells.resize(slots.size()); },
                             [&] { snapshot.neighbors.resize(slots.size()); }});
    const auto write = [&](std::uint32_t n) {
        const KernelCell& cell = cells[slots[n]];
        const auto& place = canonical_places(cell.vertex);
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t link = cell.link[place[i]], other = place_of_slot[link >> 2];
            snapshot.cells[n][i] = index_of[cell.vertex[place[i]]];
            snapshot.neighbors[n][i] = other;
            if (other == no_cell || cells[link >> 2].vertex[0] >= vertices_then) continue;
            const auto& there = canonical_places(cells[link >> 2].vertex);
            const auto back =
                std::find(there.begin(), there.end(), static_cast<int>(link & 3)) - there.begin();
            snapshot.neighbors[other][static_cast<std::size_t>(back)] = n;
        }
    };
    // Cells lie where there was room: they are fetched before they are needed, then their neighbours.
    const auto cell_at = [&](std::size_t n) -> const KernelCell& {
        return cells[slots[snapshot.changed[n]]];
    };
    parallel_for(snapshot.changed.size(), 4096, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n) {
            if (n + 2 * ahead < last) __builtin_prefetch(&cell_at(n + 2 * ahead));
            if (n + ahead < last) {
                for (const std::uint32_t link : cell_at(n + ahead).link)
                    __builtin_prefetch(&cells[link >> 2]);
            }
            write(snapshot.changed[n]);
        }
    });
}

Tetrahedralization::Tetrahedralization(std::unique_ptr<State> state) : state_(std::move(state)) {}
Tetrahedralization::Tetrahedralization(Tetrahedralization&&) noexcept = default;
Tetrahedralization& Tetrahedralization::operator=(Tetrahedralization&&) noexcept = default;
Tetrahedralization::~Tetrahedralization() = default;

Result<Tetrahedralization> Tetrahedralization::create(std::span<const Vec3> points, int threads) {
    if (points.size() > most_points) {
        return Error{ErrorKind::limit,
                     "E-DEL-003",
                     std::to_string(points.size()) + " points are too many; at most " +
                         std::to_string(most_points) + " are possible",
                     {},
                     "give a larger --size, or simplify the contours with --epsilon"};
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
                     "give contours on at least two slices, or --slice-thickness for one"};
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

const DelaunaySnapshot& Tetrahedralization::last_snapshot() const {
    return state_->snapshot;
}

std::uint64_t Tetrahedralization::cells_made() const {
    return state_->kernel.cells_made();
}

const DelaunaySnapshot& Tetrahedralization::snapshot(int threads) {
    State& state = *state_;
    std::vector<std::uint32_t> all;
    std::span<const std::uint32_t> touched = state.kernel.log();
    if (state.slots.empty()) {
        all.resize(state.kernel.cells().size());
        std::iota(all.begin(), all.end(), 0u);
        touched = all;
    }
    state.place_of_slot.resize(state.kernel.cells().size(), no_cell);
    const std::vector<std::uint32_t> removed = state.take_removed_places(touched);
    const std::vector<std::uint32_t> made = state.new_cells(touched, threads);
    state.snapshot.changed.clear();
    std::size_t n = 0;
    for (; n < made.size(); ++n) {
        state.put(made[n], n < removed.size() ? removed[n] : static_cast<std::uint32_t>(state.slots.size()));
    }
    const bool moves = n < removed.size();
    if (moves) state.fill_from_the_end(std::span(removed).subspan(n));
    // A cell that only moved may be written from two sides.
    state.write_changed(moves ? 1 : threads);
    state.vertices_then = state.kernel.vertex_count();
    state.kernel.start_log();
    return state.snapshot;
}

}  // namespace anatomesh
