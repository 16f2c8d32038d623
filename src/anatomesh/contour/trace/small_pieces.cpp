#include "anatomesh/contour/trace/small_pieces.h"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace anatomesh {

namespace {

constexpr std::uint32_t no_run = std::numeric_limits<std::uint32_t>::max();

// A maximal stretch of equal labels in a row: pixels [begin, end) of row y.
struct Run {
    std::uint32_t y, begin, end;
    std::uint16_t label;
};

// Union-find over runs. The root of a piece is the smallest run index in it, and stands for the piece.
class Pieces {
  public:
    explicit Pieces(const LabelGrid& grid) {
        find_runs(grid);
        join_rows(grid.height + 2);
    }

    // Joins two pieces; the sizes add up. Returns the root of the union.
    std::uint32_t join(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        if (a == b) return a;
        if (b < a) std::swap(a, b);
        parent_[b] = a;
        pixels_[a] += pixels_[b];
        next_[last_[a]] = b;
        last_[a] = last_[b];
        return a;
    }

    std::uint32_t root(std::uint32_t run) {
        while (parent_[run] != run) run = parent_[run] = parent_[parent_[run]];
        return run;
    }

    std::uint32_t run_count() const { return static_cast<std::uint32_t>(runs_.size()); }
    const Run& run(std::uint32_t index) const { return runs_[index]; }
    std::uint64_t pixels(std::uint32_t piece) const { return pixels_[piece]; }
    std::uint32_t next(std::uint32_t run) const { return next_[run]; }  // next run of the piece, or no_run

    // The run that holds pixel (x, y).
    std::uint32_t run_at(std::uint32_t x, std::uint32_t y) const {
        const auto first = runs_.begin() + row_first_[y], last = runs_.begin() + row_first_[y + 1];
        const auto after = std::upper_bound(
            first, last, x, [](std::uint32_t value, const Run& run) { return value < run.begin; });
        return static_cast<std::uint32_t>(after - runs_.begin()) - 1;
    }

  private:
    void find_runs(const LabelGrid& grid) {
        const std::uint32_t length = grid.row_length(), rows = grid.height + 2;
        for (std::uint32_t y = 0; y < rows; ++y) {
            row_first_.push_back(run_count());
            const std::uint16_t* row = grid.labels.data() + std::size_t{y} * length;
            for (std::uint32_t x = 0; x < length;) {
                const std::uint32_t begin = x;
                while (x < length && row[x] == row[begin]) ++x;
                runs_.push_back({y, begin, x, row[begin]});
            }
        }
        row_first_.push_back(run_count());
        for (std::uint32_t i = 0; i < run_count(); ++i) {
            parent_.push_back(i);
            last_.push_back(i);
            next_.push_back(no_run);
            pixels_.push_back(runs_[i].end - runs_[i].begin);
        }
    }

    // Joins the runs of each row with those of the row before, both walked from left to right.
    void join_rows(std::uint32_t rows) {
        for (std::uint32_t y = 1; y < rows; ++y) {
            std::uint32_t above = row_first_[y - 1], here = row_first_[y];
            while (above < row_first_[y] && here < row_first_[y + 1]) {
                const Run &a = runs_[above], &b = runs_[here];
                if (a.label == b.label) join(above, here);  // they overlap: both walks are at the same place
                if (a.end == b.end) {
                    // Two zeros that meet at a corner: this run and the other row's next one.
                    if (a.label == 0 && here + 1 < row_first_[y + 1] && runs_[here + 1].label == 0)
                        join(above, here + 1);
                    if (b.label == 0 && above + 1 < row_first_[y] && runs_[above + 1].label == 0)
                        join(above + 1, here);
                }
                const bool step_above = a.end <= b.end, step_here = b.end <= a.end;
                above += step_above;
                here += step_here;
            }
        }
    }

    std::vector<Run> runs_;
    std::vector<std::uint32_t> row_first_, parent_, last_, next_;
    std::vector<std::uint64_t> pixels_;
};

constexpr std::array<std::pair<int, int>, 4> neighbor_sides{{{0, -1}, {-1, 0}, {1, 0}, {0, 1}}};

// Calls visit(neighbour's x, y) for every pixel edge between the piece and something else.
template <class Visit>
void for_each_side(const Pieces& pieces, const LabelGrid& grid, std::uint32_t piece, std::uint16_t label,
                   Visit visit) {
    for (std::uint32_t index = piece; index != no_run; index = pieces.next(index)) {
        const Run& run = pieces.run(index);
        for (std::uint32_t x = run.begin; x < run.end; ++x) {
            for (const auto& [dx, dy] : neighbor_sides) {
                const auto nx = static_cast<std::uint32_t>(static_cast<int>(x) + dx);
                const auto ny = static_cast<std::uint32_t>(static_cast<int>(run.y) + dy);
                if (grid.at(nx, ny) != label) visit(nx, ny);
            }
        }
    }
}

// The label with which the piece shares most pixel edges; of equal ones, the lower.
std::uint16_t surrounding_label(const Pieces& pieces, const LabelGrid& grid, std::uint32_t piece,
                                std::uint16_t label) {
    std::vector<std::uint16_t> around;
    for_each_side(pieces, grid, piece, label,
                  [&](std::uint32_t x, std::uint32_t y) { around.push_back(grid.at(x, y)); });
    std::sort(around.begin(), around.end());
    std::uint16_t best = 0;
    std::ptrdiff_t best_count = 0;
    for (auto it = around.begin(); it != around.end();) {
        const auto end = std::upper_bound(it, around.end(), *it);
        if (end - it > best_count) {
            best_count = end - it;
            best = *it;
        }
        it = end;
    }
    return best;
}

// Repaints the piece and joins it with the pieces of that label that it touches. Returns the root.
std::uint32_t repaint(Pieces& pieces, LabelGrid& grid, std::uint32_t piece, std::uint16_t from,
                      std::uint16_t to) {
    std::vector<std::uint32_t> touched;
    for_each_side(pieces, grid, piece, from, [&](std::uint32_t x, std::uint32_t y) {
        if (grid.at(x, y) == to) touched.push_back(pieces.root(pieces.run_at(x, y)));
    });
    for (std::uint32_t index = piece; index != no_run; index = pieces.next(index)) {
        const Run& run = pieces.run(index);
        std::uint16_t* row = grid.labels.data() + std::size_t{run.y} * grid.row_length();
        std::fill(row + run.begin, row + run.end, to);
    }
    for (const std::uint32_t other : touched) piece = pieces.join(piece, other);
    return piece;
}

// Goes over all pieces once. Returns whether a piece of the outside was repainted, because such a piece may hang
// together across corners, where the piece of a structure that it became does not.
bool repaint_small_pieces(LabelGrid& grid, double min_pixels, SmallPieces& found) {
    Pieces pieces(grid);
    const std::uint32_t outside = pieces.root(0);  // run 0 is the first border row

    using Candidate = std::pair<std::uint64_t, std::uint32_t>;  // pixels, root
    std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> queue;
    const auto consider = [&](std::uint32_t piece) {
        const auto size = pieces.pixels(piece);
        if (piece != outside && static_cast<double>(size) < min_pixels) queue.push({size, piece});
    };
    for (std::uint32_t run = 0; run < pieces.run_count(); ++run) {
        if (pieces.root(run) == run) consider(run);
    }
    const std::uint32_t holes_before = found.holes;
    while (!queue.empty()) {
        const auto [size, piece] = queue.top();
        queue.pop();
        // An entry is stale once its piece was joined to another or has grown.
        if (pieces.root(piece) != piece || pieces.pixels(piece) != size) continue;
        const Run& run = pieces.run(piece);
        const std::uint16_t label = grid.at(run.begin, run.y);
        (label == 0 ? found.holes : found.islands) += 1;
        (label == 0 ? found.hole_pixels : found.island_pixels) += size;
        consider(repaint(pieces, grid, piece, label, surrounding_label(pieces, grid, piece, label)));
    }
    return found.holes != holes_before;
}

}  // namespace

SmallPieces leave_out_small_pieces(LabelGrid& grid, double min_pixels) {
    SmallPieces found;
    if (!(min_pixels > 1)) return found;
    // Every repainting removes pixel edges between unlike labels, so the passes come to an end.
    while (repaint_small_pieces(grid, min_pixels, found)) continue;
    return found;
}

}  // namespace anatomesh
