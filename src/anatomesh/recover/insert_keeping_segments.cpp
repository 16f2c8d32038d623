#include "anatomesh/recover/insert_keeping_segments.h"

#include <algorithm>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/recover/cavity.h"

namespace anatomesh {

namespace {

// A point in conflict with more cells is not inserted. [cells; >= 1; B]
constexpr std::size_t most_in_conflict = 100;
constexpr int most_steps = 200;  // A walk to a point takes no more. [cells; >= 1; B]

class Inserter {
  public:
    Inserter(EditMesh& mesh, const KeptEdges& kept) : mesh_(mesh), cavity_(mesh, kept) {}

    bool insert(Vec3 p, std::uint32_t beside, double least_shape) {
        const std::uint32_t c = cell_of(p, beside);
        if (c == no_cell) return false;
        find_conflict(c, p);
        if (try_at(p, least_shape)) return true;
        conflict_.assign(1, c);
        return try_at(p, least_shape);
    }

  private:
    bool try_at(Vec3 p, double least_shape) {
        cavity_.reset(conflict_, {no_cell, p});
        if (!cavity_.open() || !(cavity_.worst() > least_shape)) return false;
        cavity_.fill();
        return true;
    }

    // A cell that holds p, by a walk from a vertex; no_cell where that does not end.
    std::uint32_t cell_of(Vec3 p, std::uint32_t from) {
        mesh_.star(from, star_);
        if (star_.empty()) return no_cell;
        std::uint32_t c = star_[0], last = no_cell;
        for (int step = 0; step < most_steps; ++step) {
            std::uint32_t next = c;
            for (int i = 0; i < 4 && next == c; ++i) {
                const Cell& cell = mesh_.cell(c);
                const auto& f = facet_vertices[i];
                if (mesh_.neighbor(c, i) == last) continue;
                if (orient3d(p, mesh_.point(cell[f[0]]), mesh_.point(cell[f[1]]), mesh_.point(cell[f[2]])) <
                    0)
                    next = mesh_.neighbor(c, i);
            }
            if (next == c || next == no_cell) return next;
            last = c;
            c = next;
        }
        return no_cell;
    }

    // The cells joined to c whose circumspheres hold p.
    void find_conflict(std::uint32_t c, Vec3 p) {
        conflict_.assign(1, c);
        for (std::size_t n = 0; n < conflict_.size() && conflict_.size() <= most_in_conflict; ++n) {
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t next = mesh_.neighbor(conflict_[n], i);
                if (next == no_cell || std::find(conflict_.begin(), conflict_.end(), next) != conflict_.end())
                    continue;
                const Cell& v = mesh_.cell(next);
                if (in_sphere(mesh_.point(v[0]), mesh_.point(v[1]), mesh_.point(v[2]), mesh_.point(v[3]), p) >
                    0)
                    conflict_.push_back(next);
            }
        }
    }

    EditMesh& mesh_;
    Cavity cavity_;
    std::vector<std::uint32_t> star_, conflict_;
};

}  // namespace

std::vector<std::uint32_t> insert_keeping_segments(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                                   std::span<const Vec3> points,
                                                   std::span<const std::uint32_t> beside,
                                                   const std::vector<Subsegment>& subsegments,
                                                   const std::vector<std::uint8_t>& fixed,
                                                   double least_shape) {
    EditMesh edit(std::move(mesh), neighbors);
    const KeptEdges kept = kept_edges(fixed, subsegments);
    Inserter inserter(edit, kept);
    for (std::size_t n = 0; n < points.size(); ++n) inserter.insert(points[n], beside[n], least_shape);
    return take_with_undecided(std::move(edit), mesh, neighbors);
}

}  // namespace anatomesh
