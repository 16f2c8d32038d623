#include "anatomesh/image/components.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <utility>

namespace anatomesh {

namespace {

// Equal labels other than 0 along a row: voxels [begin, end) of it.
struct Run {
    std::uint32_t begin, end;
    std::uint16_t label;
};

class Components {
  public:
    explicit Components(const LabelMap& labels) : size_(labels.geometry.size) {
        find_runs(labels);
        parent_.resize(runs_.size());
        for (std::size_t r = 0; r < parent_.size(); ++r) parent_[r] = r;
        for (std::size_t k = 0; k < size_[2]; ++k) {
            for (std::size_t j = 0; j < size_[1]; ++j) join_with_earlier_rows(j, k);
        }
    }

    std::size_t root(std::size_t run) {
        while (parent_[run] != run) run = parent_[run] = parent_[parent_[run]];
        return run;
    }

    const std::vector<Run>& runs() const { return runs_; }
    std::size_t row_count() const { return first_.size() - 1; }
    std::size_t row_begin(std::size_t row) const { return first_[row]; }
    std::size_t row_end(std::size_t row) const { return first_[row + 1]; }

  private:
    void find_runs(const LabelMap& labels) {
        const std::size_t rows = std::size_t{size_[1]} * size_[2];
        first_.reserve(rows + 1);
        first_.push_back(0);
        const std::uint32_t length = size_[0];
        for (std::size_t row = 0; row < rows; ++row) {
            const std::uint16_t* voxels = labels.voxels.data() + row * length;
            for (std::uint32_t i = 0; i < length;) {
                if (voxels[i] == 0) {
                    // Most of an image is empty, so four voxels are looked at at once.
                    std::uint64_t four = 0;
                    while (i + 4 <= length && (std::memcpy(&four, voxels + i, sizeof four), four == 0))
                        i += 4;
                    while (i < length && voxels[i] == 0) ++i;
                    continue;
                }
                const std::uint32_t begin = i;
                while (i < length && voxels[i] == voxels[begin]) ++i;
                runs_.push_back({begin, i, voxels[begin]});
            }
            first_.push_back(runs_.size());
        }
    }

    // The four rows before row (j, k) in voxel order that touch it.
    void join_with_earlier_rows(std::size_t j, std::size_t k) {
        const std::size_t row = k * size_[1] + j;
        if (j > 0) join_rows(row, row - 1);
        if (k == 0) return;
        const std::size_t below = row - size_[1];
        join_rows(row, below);
        if (j > 0) join_rows(row, below - 1);
        if (j + 1 < size_[1]) join_rows(row, below + 1);
    }

    // Joins equal labels that overlap or meet at a corner.
    void join_rows(std::size_t row, std::size_t other_row) {
        std::size_t a = first_[row], b = first_[other_row];
        const std::size_t a_end = first_[row + 1], b_end = first_[other_row + 1];
        while (a < a_end && b < b_end) {
            if (runs_[a].end < runs_[b].begin) {
                ++a;
            } else if (runs_[b].end < runs_[a].begin) {
                ++b;
            } else {
                if (runs_[a].label == runs_[b].label) join(a, b);
                // The next run may start where this one ends and touch the other's last voxel at a corner.
                const bool a_next_touches = a + 1 < a_end && runs_[a + 1].begin <= runs_[b].end;
                const bool step_a =
                    runs_[a].end < runs_[b].end || (runs_[a].end == runs_[b].end && a_next_touches);
                if (runs_[a].end == runs_[b].end && a_next_touches && b + 1 < b_end &&
                    runs_[b + 1].begin <= runs_[a].end && runs_[b + 1].label == runs_[a].label) {
                    join(a, b + 1);
                }
                ++(step_a ? a : b);
            }
        }
    }

    void join(std::size_t a, std::size_t b) {
        a = root(a);
        b = root(b);
        if (a == b) return;
        if (b < a) std::swap(a, b);
        parent_[b] = a;  // the root is the first run of the piece
    }

    std::array<std::uint32_t, 3> size_;
    std::vector<Run> runs_;
    std::vector<std::size_t> first_;  // per row
    std::vector<std::size_t> parent_;
};

struct Piece {
    std::uint16_t label;
    std::uint64_t voxels;
    std::size_t root;
};

}  // namespace

ComponentStats keep_largest(LabelMap& labels, std::uint32_t count) {
    assert(count >= 1 && labels.voxels.size() == labels.geometry.voxel_count());
    Components components(labels);
    const std::vector<Run>& runs = components.runs();
    std::vector<std::uint64_t> voxels(runs.size(), 0);
    for (std::size_t r = 0; r < runs.size(); ++r) voxels[components.root(r)] += runs[r].end - runs[r].begin;

    // Pieces are ordered by label, then by falling size, then in voxel order.
    std::vector<Piece> pieces;
    for (std::size_t r = 0; r < runs.size(); ++r) {
        if (voxels[r] > 0) pieces.push_back({runs[r].label, voxels[r], r});
    }
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
        if (a.label != b.label) return a.label < b.label;
        if (a.voxels != b.voxels) return a.voxels > b.voxels;
        return a.root < b.root;
    });

    ComponentStats stats;
    stats.structures.resize(labels.structures.size());
    std::vector<std::uint8_t> kept(runs.size(), 0);
    for (const Piece& piece : pieces) {
        assert(piece.label <= stats.structures.size());
        auto& of = stats.structures[piece.label - 1u];
        ++of.pieces;
        of.voxels += piece.voxels;
        if (of.pieces_kept == count) continue;
        ++of.pieces_kept;
        of.voxels_kept += piece.voxels;
        kept[piece.root] = 1;
    }

    const std::size_t length = labels.geometry.size[0];
    for (std::size_t row = 0; row < components.row_count(); ++row) {
        for (std::size_t r = components.row_begin(row); r < components.row_end(row); ++r) {
            if (kept[components.root(r)]) continue;
            std::fill(labels.voxels.begin() + static_cast<std::ptrdiff_t>(row * length + runs[r].begin),
                      labels.voxels.begin() + static_cast<std::ptrdiff_t>(row * length + runs[r].end),
                      std::uint16_t{0});
        }
    }
    return stats;
}

std::vector<MissedPieces> pieces_between(const LabelMap& labels, const KeptSlices& kept,
                                         std::uint64_t least_voxels) {
    assert(kept.axis < 3 && kept.offset < kept.every);
    assert(labels.voxels.size() == labels.geometry.voxel_count());
    std::vector<MissedPieces> missed(labels.structures.size());
    if (kept.every == 1) return missed;
    Components components(labels);
    const std::vector<Run>& runs = components.runs();
    // Whether one of the slices [begin, end) is kept.
    const auto any_kept = [&](std::uint64_t begin, std::uint64_t end) {
        return (begin + kept.every - 1 - kept.offset) / kept.every <
               (end + kept.every - 1 - kept.offset) / kept.every;
    };
    std::vector<std::uint64_t> voxels(runs.size(), 0);
    std::vector<std::uint8_t> met(runs.size(), 0);
    const std::size_t height = labels.geometry.size[1];
    for (std::size_t row = 0; row < components.row_count(); ++row) {
        const std::size_t slice = kept.axis == 2 ? row / height : row % height;
        for (std::size_t r = components.row_begin(row); r < components.row_end(row); ++r) {
            const std::size_t root = components.root(r);
            voxels[root] += runs[r].end - runs[r].begin;
            if (kept.axis == 0 ? any_kept(runs[r].begin, runs[r].end) : any_kept(slice, slice + 1))
                met[root] = 1;
        }
    }
    for (std::size_t r = 0; r < runs.size(); ++r) {
        if (voxels[r] < std::max<std::uint64_t>(least_voxels, 1) || met[r]) continue;
        MissedPieces& of = missed[runs[r].label - 1u];
        ++of.pieces;
        of.voxels += voxels[r];
        of.largest = std::max(of.largest, voxels[r]);
    }
    return missed;
}

}  // namespace anatomesh
