#include "anatomesh/cut/crumbs.h"

#include <algorithm>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/quality.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_cells = 64;

class CrumbSearch {
  public:
    CrumbSearch(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                std::span<const std::uint8_t> given, double most_mm3)
        : mesh_(mesh),
          neighbors_(neighbors),
          given_(given),
          most_mm3_(most_mm3),
          state_(mesh.cells.size(), State::unknown) {}

    // Whether the piece at the cell, not looked at yet, is a crumb: piece() and beyond() then.
    bool found(std::uint32_t cell) {
        if (state_[cell] != State::unknown || !may_be_in_one(cell)) return false;
        piece_ = {cell};
        state_[cell] = State::in_piece;
        const bool whole = grow();
        for (const std::uint32_t c : piece_) state_[c] = State::known;
        return whole && has_one_neighbor();
    }

    // Whether the cell alone does not rule a crumb that begins with it out.
    bool may_be_in_one(std::uint32_t c) const {
        return on_interface(c) && !is_drawn(c) && volume(c) <= most_mm3_;
    }

    const std::vector<std::uint32_t>& piece() const { return piece_; }
    Region beyond() const { return beyond_; }

  private:
    enum class State : std::uint8_t { unknown, in_piece, known };

    bool on_interface(std::uint32_t c) const {
        return std::any_of(neighbors_.begin() + 4 * std::size_t{c},
                           neighbors_.begin() + 4 * std::size_t{c} + 4,
                           [&](std::uint32_t n) { return n != no_cell && differs(n, c); });
    }
    bool differs(std::uint32_t n, std::uint32_t c) const { return mesh_.regions[n] != mesh_.regions[c]; }

    bool is_drawn(std::uint32_t c) const {
        const Cell& cell = mesh_.cells[c];
        return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) { return given_[v] != 0; });
    }
    double volume(std::uint32_t c) const {
        const Cell& v = mesh_.cells[c];
        return signed_volume(mesh_.points[v[0]], mesh_.points[v[1]], mesh_.points[v[2]], mesh_.points[v[3]]);
    }

    // Over facets, until the piece ends; not where it is too large, has a contour's vertex, reaches the end
    // of the mesh, or joins what was found to.
    bool grow() {
        double total = 0;
        for (std::size_t n = 0; n < piece_.size(); ++n) {
            const std::uint32_t c = piece_[n];
            total += volume(c);
            if (total > most_mm3_ || piece_.size() > most_cells || is_drawn(c)) return false;
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t next = neighbors_[4 * std::size_t{c} + i];
                if (next == no_cell) return false;
                if (differs(next, c) || state_[next] == State::in_piece) continue;
                if (state_[next] == State::known) return false;
                state_[next] = State::in_piece;
                piece_.push_back(next);
            }
        }
        return true;
    }

    bool has_one_neighbor() {
        bool any = false;
        for (const std::uint32_t c : piece_) {
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t next = neighbors_[4 * std::size_t{c} + i];
                if (!differs(next, c)) continue;
                if (any && mesh_.regions[next] != beyond_) return false;
                beyond_ = mesh_.regions[next];
                any = true;
            }
        }
        return any;
    }

    const TetMesh& mesh_;
    std::span<const std::uint32_t> neighbors_;
    std::span<const std::uint8_t> given_;
    double most_mm3_;
    std::vector<State> state_;
    std::vector<std::uint32_t> piece_;
    Region beyond_ = 0;
};

}  // namespace

CrumbStats give_crumbs_away(TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                            std::span<const std::uint8_t> given, const CrumbOptions& options, int threads) {
    CrumbStats stats;
    CrumbSearch search(mesh, neighbors, given, options.most_mm3);
    const std::vector<std::uint32_t> cells = parallel_collect<std::uint32_t>(
        mesh.cells.size(), 16384, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& small) {
            for (std::size_t c = first; c < last; ++c) {
                if (search.may_be_in_one(static_cast<std::uint32_t>(c)))
                    small.push_back(static_cast<std::uint32_t>(c));
            }
        });
    for (const std::uint32_t c : cells) {
        if (!search.found(c)) continue;
        for (const std::uint32_t member : search.piece()) mesh.regions[member] = search.beyond();
        ++stats.pieces;
        stats.cells += search.piece().size();
    }
    return stats;
}

}  // namespace anatomesh
