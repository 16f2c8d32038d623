#include "anatomesh/mesh/edit/edit_mesh.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"

namespace anatomesh {

EditMesh::EditMesh(TetMesh mesh, std::span<const std::uint32_t> neighbors)
    : points_(std::move(mesh.points)),
      cells_(std::move(mesh.cells)),
      regions_(std::move(mesh.regions)),
      neighbors_(cells_.size()),
      cell_of_(points_.size(), no_cell),
      mark_(cells_.size(), 0) {
    assert(neighbors.size() == 4 * cells_.size());
    // Few cells more come than go: room for them, and the arrays need not grow to twice their size.
    const std::size_t room = cells_.size() + cells_.size() / 32;
    cells_.reserve(room);
    regions_.reserve(room);
    neighbors_.reserve(room);
    mark_.reserve(room);
    points_.reserve(points_.size() + points_.size() / 32);
    for (std::uint32_t c = 0; c < cells_.size(); ++c) {
        for (int i = 0; i < 4; ++i) {
            neighbors_[c][i] = neighbors[4 * c + i];
            cell_of_[cells_[c][i]] = c;
        }
    }
}

TetMesh EditMesh::take(std::vector<std::uint32_t>& neighbors, int threads) && {
    // Cells are marked with their new numbers.
    std::uint32_t kept = 0;
    for (std::size_t c = 0; c < cells_.size(); ++c) {
        mark_[c] = cells_[c][0] == no_cell ? no_cell : kept++;
    }
    neighbors.resize(4 * std::size_t{kept});
    const auto renumber = [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) {
            const std::uint32_t now = mark_[c];
            if (now == no_cell) continue;
            for (std::size_t i = 0; i < 4; ++i) {
                const std::uint32_t across = neighbors_[c][i];
                neighbors[4 * std::size_t{now} + i] = across == no_cell ? no_cell : mark_[across];
            }
        }
    };
    const auto close_up = [&](auto& list) {
        for (std::size_t c = 0; c < mark_.size(); ++c) {
            if (mark_[c] != no_cell) list[mark_[c]] = list[c];
        }
        list.resize(kept);
    };
    parallel_tasks(threads, {[&] { close_up(cells_); }, [&] { close_up(regions_); },
                             [&] { parallel_for(mark_.size(), 16384, threads, renumber); }});
    return {std::move(points_), std::move(cells_), std::move(regions_)};
}

std::uint32_t EditMesh::add_point(Vec3 p) {
    points_.push_back(p);
    cell_of_.push_back(no_cell);
    return static_cast<std::uint32_t>(points_.size() - 1);
}

void EditMesh::star(std::uint32_t v, std::vector<std::uint32_t>& cells) {
    cells.clear();
    if (cell_of_[v] == no_cell) return;
    ++stamp_;
    cells.push_back(cell_of_[v]);
    mark_[cell_of_[v]] = stamp_;
    for (std::size_t n = 0; n < cells.size(); ++n) {
        const std::uint32_t c = cells[n];
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t across = neighbors_[c][i];
            if (cells_[c][i] == v || across == no_cell || mark_[across] == stamp_) continue;
            mark_[across] = stamp_;
            cells.push_back(across);
        }
    }
}

void EditMesh::shared_star(std::uint32_t v, std::vector<std::uint32_t>& cells) const {
    cells.clear();
    if (cell_of_[v] == no_cell) return;
    cells.push_back(cell_of_[v]);
    for (std::size_t n = 0; n < cells.size(); ++n) {
        const std::uint32_t c = cells[n];
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t across = neighbors_[c][i];
            if (cells_[c][i] == v || across == no_cell) continue;
            if (std::find(cells.begin(), cells.end(), across) == cells.end()) cells.push_back(across);
        }
    }
}

// From cell c = (a, b, leave, keep) across its facet (a, b, keep): the cell there and its fourth vertex.
std::uint32_t EditMesh::next_round(std::uint32_t c, std::uint32_t a, std::uint32_t b, std::uint32_t leave,
                                   std::uint32_t keep, std::uint32_t& fresh) const {
    int i = 0;
    while (cells_[c][i] != leave) ++i;
    const std::uint32_t next = neighbors_[c][i];
    if (next == no_cell) return no_cell;
    for (const std::uint32_t v : cells_[next]) {
        if (v != a && v != b && v != keep) fresh = v;
    }
    return next;
}

void EditMesh::ring(std::uint32_t c, int e, EdgeRing& ring) const {
    const Cell& cell = cells_[c];
    ring.a = cell[cell_edges[e][0]];
    ring.b = cell[cell_edges[e][1]];
    ring.cells.assign(1, c);
    std::uint32_t leave = cell[across_edges[e][0]], keep = cell[across_edges[e][1]];
    ring.ring.assign(1, leave);
    for (std::uint32_t at = c;;) {
        std::uint32_t fresh = no_cell;
        at = next_round(at, ring.a, ring.b, leave, keep, fresh);
        ring.closed = at == c;
        if (at == c || at == no_cell) return;
        ring.cells.push_back(at);
        ring.ring.push_back(keep);
        leave = keep;
        keep = fresh;
    }
}

bool EditMesh::edge_on_interface(std::uint32_t c, int e) const {
    const std::uint32_t a = cells_[c][cell_edges[e][0]], b = cells_[c][cell_edges[e][1]];
    std::uint32_t leave = cells_[c][across_edges[e][0]], keep = cells_[c][across_edges[e][1]];
    for (std::uint32_t at = c;;) {
        std::uint32_t fresh = no_cell;
        at = next_round(at, a, b, leave, keep, fresh);
        if (at == c) return false;
        if (at == no_cell || regions_[at] != regions_[c]) return true;
        leave = keep;
        keep = fresh;
    }
}

bool EditMesh::vertex_on_interface(std::uint32_t v) {
    star(v, scratch_);
    return std::any_of(scratch_.begin(), scratch_.end(),
                       [&](std::uint32_t c) { return regions_[c] != regions_[scratch_[0]]; });
}

void EditMesh::replace(std::span<const std::uint32_t> removed, std::span<const Cell> added,
                       std::span<const Region> regions, std::vector<std::uint32_t>& slots) {
    Note note{Note::replaced, 0, {}, 0, {}, {}};
    if (noted_) {
        note.before.removed.assign(removed.begin(), removed.end());
        for (const std::uint32_t c : removed) {
            note.before.added.push_back(cells_[c]);
            note.before.regions.push_back(regions_[c]);
        }
    }
    take_slots(removed, added.size(), slots);
    put(removed, added, regions, slots, sides_);
    free_slots(removed, added.size());
    if (!noted_) return;
    note.slots = slots;
    notes_.push_back(std::move(note));
}

void EditMesh::end_attempt(bool keep) {
    noted_ = false;
    for (; !keep && !notes_.empty(); notes_.pop_back()) take_back(notes_.back());
    notes_.clear();
}

std::vector<std::uint32_t> EditMesh::changed_cells() {
    std::vector<std::uint32_t> cells;
    for (const Note& note : notes_) {
        if (note.kind == Note::moved) {
            star(note.index, scratch_);
            cells.insert(cells.end(), scratch_.begin(), scratch_.end());
        } else if (note.kind == Note::given) {
            cells.push_back(note.index);
        } else {
            cells.insert(cells.end(), note.slots.begin(), note.slots.end());
            cells.insert(cells.end(), note.before.removed.begin(), note.before.removed.end());
        }
    }
    sort_distinct(cells);
    const std::size_t changed = cells.size();
    for (std::size_t n = 0; n < changed; ++n) {
        if (!alive(cells[n])) continue;
        for (const std::uint32_t across : neighbors_[cells[n]]) {
            if (across != no_cell) cells.push_back(across);
        }
    }
    sort_distinct(cells);
    return cells;
}

std::vector<EditMesh::CellState> EditMesh::states_before(std::span<const std::uint32_t> cells) const {
    std::vector<CellState> states;
    for (const std::uint32_t c : cells) states.push_back({cells_[c], regions_[c]});
    const auto state_of = [&](std::uint32_t c) -> CellState& {
        const auto at = std::lower_bound(cells.begin(), cells.end(), c);
        assert(at != cells.end() && *at == c);
        return states[static_cast<std::size_t>(at - cells.begin())];
    };
    // As take_back() does it with the mesh.
    for (auto note = notes_.rbegin(); note != notes_.rend(); ++note) {
        if (note->kind == Note::given) state_of(note->index).region = note->region;
        if (note->kind != Note::replaced) continue;
        for (const std::uint32_t c : note->slots) state_of(c).cell[0] = no_cell;
        for (std::size_t n = 0; n < note->before.removed.size(); ++n)
            state_of(note->before.removed[n]) = {note->before.added[n], note->before.regions[n]};
    }
    return states;
}

void EditMesh::take_back(const Note& note) {
    if (note.kind == Note::moved) {
        points_[note.index] = note.point;
        return;
    }
    if (note.kind == Note::given) {
        regions_[note.index] = note.region;
        return;
    }
    const std::size_t were = note.before.removed.size(), are = note.slots.size();
    put(note.slots, note.before.added, note.before.regions, note.before.removed, sides_);
    // Numbers were taken from the end of the list of free ones, and left there.
    for (std::size_t n = are; n < were; ++n) free_.pop_back();
    for (std::size_t n = are; n > were; --n) free_.push_back(note.slots[n - 1]);
}

std::vector<std::uint8_t> EditMesh::replace_apart(std::span<CellExchange> exchanges, int threads) {
    std::vector<std::uint8_t> done(exchanges.size(), 0), taken(points_.size(), 0);
    std::vector<CellExchange*> apart;
    for (std::size_t n = 0; n < exchanges.size(); ++n) {
        CellExchange& exchange = exchanges[n];
        const auto is_taken = [&](const Cell& cell) {
            return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return taken[v] != 0; });
        };
        if (std::any_of(exchange.added.begin(), exchange.added.end(), is_taken)) continue;
        for (const Cell& cell : exchange.added) {
            for (const std::uint32_t v : cell) taken[v] = 1;
        }
        take_slots(exchange.removed, exchange.added.size(), exchange.slots);
        apart.push_back(&exchange);
        done[n] = 1;
    }
    parallel_for(apart.size(), 128, threads, [&](std::size_t first, std::size_t last) {
        std::vector<Side> sides;
        for (std::size_t n = first; n < last; ++n) {
            const CellExchange& exchange = *apart[n];
            put(exchange.removed, exchange.added, exchange.regions, exchange.slots, sides);
        }
    });
    // Not before: none may take a number that another one's cell still has.
    for (const CellExchange* exchange : apart) free_slots(exchange->removed, exchange->added.size());
    return done;
}

void EditMesh::take_slots(std::span<const std::uint32_t> removed, std::size_t added,
                          std::vector<std::uint32_t>& slots) {
    cells_made_ += added;
    slots.assign(removed.begin(),
                 removed.begin() + static_cast<std::ptrdiff_t>(std::min(added, removed.size())));
    while (slots.size() < added) {
        if (!free_.empty()) {
            slots.push_back(free_.back());
            free_.pop_back();
            continue;
        }
        slots.push_back(static_cast<std::uint32_t>(cells_.size()));
        cells_.emplace_back();
        regions_.emplace_back();
        neighbors_.emplace_back();
        mark_.push_back(0);
    }
}

void EditMesh::free_slots(std::span<const std::uint32_t> removed, std::size_t added) {
    for (std::size_t n = added; n < removed.size(); ++n) free_.push_back(removed[n]);
}

void EditMesh::put(std::span<const std::uint32_t> removed, std::span<const Cell> added,
                   std::span<const Region> regions, std::span<const std::uint32_t> slots,
                   std::vector<Side>& sides) {
    const auto sorted = [](const Cell& cell, int i) {
        const auto& f = facet_vertices[i];
        std::array<std::uint32_t, 3> facet{cell[f[0]], cell[f[1]], cell[f[2]]};
        if (facet[0] > facet[1]) std::swap(facet[0], facet[1]);
        if (facet[1] > facet[2]) std::swap(facet[1], facet[2]);
        if (facet[0] > facet[1]) std::swap(facet[0], facet[1]);
        return facet;
    };
    // The cells beyond the outer facets, seen from there; hull facets have none.
    sides.clear();
    for (const std::uint32_t c : removed) {
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t across = neighbors_[c][i];
            if (across == no_cell || std::find(removed.begin(), removed.end(), across) != removed.end())
                continue;
            int back = 0;
            while (neighbors_[across][back] != c) ++back;
            sides.push_back({sorted(cells_[c], i), across, back});
        }
        for (const std::uint32_t v : cells_[c]) cell_of_[v] = no_cell;
    }
    for (const std::uint32_t c : removed) cells_[c][0] = no_cell;
    // Vertices whose listed cell went and that have no new one keep a cell outside the cavity.
    for (const Side& side : sides) {
        for (const std::uint32_t v : side.facet) cell_of_[v] = side.cell;
    }
    for (std::size_t n = 0; n < added.size(); ++n) {
        const std::uint32_t slot = slots[n];
        cells_[slot] = added[n];
        regions_[slot] = regions[n];
        neighbors_[slot].fill(no_cell);
        for (int i = 0; i < 4; ++i) {
            cell_of_[added[n][i]] = slot;
            sides.push_back({sorted(added[n], i), slot, i});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) { return x.facet < y.facet; });
    for (std::size_t n = 0; n + 1 < sides.size(); ++n) {
        const Side &x = sides[n], &y = sides[n + 1];
        if (x.facet != y.facet) continue;
        assert(n + 2 == sides.size() || sides[n + 2].facet != x.facet);
        neighbors_[x.cell][x.index] = y.cell;
        neighbors_[y.cell][y.index] = x.cell;
        ++n;
    }
}

}  // namespace anatomesh
