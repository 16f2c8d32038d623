#include "anatomesh/recover/recover_segments.h"

#include <algorithm>
#include <array>
#include <optional>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/recover/cavity.h"
#include "anatomesh/refine/missing_segments.h"

namespace anatomesh {

namespace {

// A subsegment that pierces more cells is not recovered. [cells; >= 1; B]
constexpr std::size_t most_pierced = 100;
// A subsegment is split at these shares of its length, in this order.
// [1; 0 to 1; M 2026-11 fetal brain and crossing stacks]
constexpr std::array<double, 5> shares{0.5, 0.35, 0.65, 0.2, 0.8};
// Free vertices nearer to a subsegment than this may go,
// [its lengths; 0 to 0.5; M 2026-11 fetal brain and crossing stacks]
constexpr double near_share = 0.45;
// so far from its ends, [its lengths; 0 to 0.5; M 2026-11 fetal brain and crossing stacks]
constexpr double from_ends = 0.1;
constexpr std::size_t most_near = 3;  // no more of them, [vertices; >= 0; B]
// where that makes the worst cell so many times better. [1; >= 1; M 2026-11 fetal brain and crossing stacks]
constexpr double drop_gain = 1.25;
// A better shape than this is not looked for. [shape, 1 for good cells; 0 to 1; B]
constexpr double enough = 0.8;

struct Missing {
    std::uint32_t a, b;
    MeshEdge subsegment;  // that it is, or is a part of
    int splits = 0;
};

class Recoverer {
  public:
    Recoverer(EditMesh& mesh, KeptEdges kept, const RecoverOptions& options)
        : mesh_(mesh), kept_(std::move(kept)), options_(options), cavity_(mesh_, kept_) {}

    bool is_edge(std::uint32_t a, std::uint32_t b) {
        mesh_.star(a, star_);
        return std::any_of(star_.begin(), star_.end(), [&](std::uint32_t c) {
            return std::find(mesh_.cell(c).begin(), mesh_.cell(c).end(), b) != mesh_.cell(c).end();
        });
    }

    // Looks for a way to make the subsegment an edge, or two.
    bool recover(const Missing& subsegment) {
        best_.reset();
        pierce(subsegment.a, subsegment.b);
        if (pierced_.empty() || pierced_.size() > most_pierced) return false;
        find_near(subsegment);
        try_without(subsegment, {});
        for (std::size_t n = 0; n < near_.size(); ++n) {
            const std::span<const Near> near = near_;
            try_without(subsegment, near.first(n + 1));
            if (n > 0) try_without(subsegment, near.subspan(n, 1));
        }
        return best_.has_value();
    }

    // Looks for a place for a vertex on the subsegment; the halves may be missing.
    bool split(const Missing& subsegment) {
        best_.reset();
        pierce(subsegment.a, subsegment.b);
        for (const double share : shares) {
            const Vec3 p = point(subsegment, share);
            base_.clear();
            for (const std::uint32_t c : pierced_) {
                if (holds(c, p)) base_.push_back(c);
            }
            if (!base_.empty()) try_apex({no_cell, p}, 1);
        }
        return best_.has_value();
    }

    // Does what recover() or split() found best for a subsegment. Returns the new vertex, or no_cell.
    std::uint32_t commit(const MeshEdge& subsegment) {
        cavity_.reset(best_->base, best_->apex);
        cavity_.open();
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t c : cavity_.cells())
            vertices.insert(vertices.end(), mesh_.cell(c).begin(), mesh_.cell(c).end());
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
        const std::uint32_t v = cavity_.fill();
        made_for_.resize(mesh_.cell_count());
        for (const std::uint32_t c : cavity_.filled()) made_for_[c] = subsegment;
        for (const std::uint32_t u : vertices) {
            mesh_.star(u, star_);
            dropped_ += star_.empty();
        }
        return best_->apex.vertex == no_cell ? v : no_cell;
    }

    void keep(std::uint32_t a, std::uint32_t b) { kept_.add(a, b); }
    std::uint64_t dropped() const { return dropped_; }

    // By new cell, rising.
    std::vector<MeshEdge> made_for() const {
        std::vector<MeshEdge> subsegments;
        for (std::uint32_t c = 0; c < mesh_.cell_count(); ++c) {
            if (mesh_.alive(c) && mesh_.region(c) == undecided_region) subsegments.push_back(made_for_[c]);
        }
        return subsegments;
    }

  private:
    struct Choice {
        std::vector<std::uint32_t> base;
        Cavity::Apex apex;
        double shape;
    };
    // A free vertex beside a subsegment.
    struct Near {
        double distance, share;
        std::uint32_t vertex;
    };

    Vec3 point(const Missing& subsegment, double share) const {
        const Vec3 a = mesh_.point(subsegment.a), b = mesh_.point(subsegment.b);
        return a + share * (b - a);
    }

    // The cells that the subsegment passes through, and the stars of these vertices, give way to those of an
    // end or of a new vertex.
    void try_without(const Missing& subsegment, std::span<const Near> gone) {
        base_ = pierced_;
        for (const Near& near : gone) add_star(near.vertex);
        const double factor = gone.empty() ? 1 : 1 / drop_gain;
        try_apex({subsegment.a, {}}, factor);
        try_apex({subsegment.b, {}}, factor);
        for (const Near& near : gone) try_apex({no_cell, point(subsegment, near.share)}, factor);
        for (const double share : shares) try_apex({no_cell, point(subsegment, share)}, factor);
    }

    void try_apex(const Cavity::Apex& apex, double factor) {
        const double bar = best_ ? best_->shape : options_.least_shape;
        if (bar >= factor || (best_ && best_->shape >= enough)) return;
        cavity_.reset(base_, apex);
        if (!cavity_.open()) return;
        const double shape = factor * cavity_.worst();
        if (shape > bar) best_ = Choice{base_, apex, shape};
    }

    // All cells that the subsegment passes through or touches between its ends.
    void pierce(std::uint32_t a, std::uint32_t b) {
        const Vec3 p = mesh_.point(a), q = mesh_.point(b);
        pierced_.clear();
        mesh_.star(a, star_);
        for (const std::uint32_t c : star_) {
            if (touches(c, p, q)) pierced_.push_back(c);
        }
        for (std::size_t n = 0; n < pierced_.size() && pierced_.size() <= most_pierced; ++n) {
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t next = mesh_.neighbor(pierced_[n], i);
                const bool known = std::find(pierced_.begin(), pierced_.end(), next) != pierced_.end();
                if (next != no_cell && !known && touches(next, p, q)) pierced_.push_back(next);
            }
        }
    }

    bool touches(std::uint32_t c, Vec3 p, Vec3 q) const {
        return meets(c, 0, p, q) || meets(c, 1, p, q) || meets(c, 2, p, q) || meets(c, 3, p, q);
    }

    // Whether the open segment from p to q meets the closed facet, and does not lie in its plane.
    bool meets(std::uint32_t c, int i, Vec3 p, Vec3 q) const {
        const auto [u, v, w] = corners(c, i);
        if (orient3d(u, v, w, p) * orient3d(u, v, w, q) >= 0) return false;
        const int r = orient3d(p, q, u, v), s = orient3d(p, q, v, w), t = orient3d(p, q, w, u);
        return (r >= 0 && s >= 0 && t >= 0) || (r <= 0 && s <= 0 && t <= 0);
    }

    bool holds(std::uint32_t c, Vec3 p) const {
        for (int i = 0; i < 4; ++i) {
            const auto [u, v, w] = corners(c, i);
            if (orient3d(p, u, v, w) < 0) return false;
        }
        return true;
    }

    std::array<Vec3, 3> corners(std::uint32_t c, int i) const {
        const Cell& cell = mesh_.cell(c);
        const auto& f = facet_vertices[i];
        return {mesh_.point(cell[f[0]]), mesh_.point(cell[f[1]]), mesh_.point(cell[f[2]])};
    }

    // Free vertices of the cells that it passes through, the nearest first.
    void find_near(const Missing& subsegment) {
        near_.clear();
        const Vec3 a = mesh_.point(subsegment.a), way = mesh_.point(subsegment.b) - a;
        const double span = length(way);
        for (const std::uint32_t c : pierced_) {
            for (const std::uint32_t v : mesh_.cell(c)) {
                if (kept_.fixed(v)) continue;
                const Vec3 offset = mesh_.point(v) - a;
                const double share = dot(offset, way) / (span * span);
                const double distance = length(offset - share * way);
                if (share < from_ends || share > 1 - from_ends || distance > near_share * span) continue;
                near_.push_back({distance, share, v});
            }
        }
        std::sort(near_.begin(), near_.end(), [](const Near& x, const Near& y) {
            return x.distance != y.distance ? x.distance < y.distance : x.vertex < y.vertex;
        });
        const auto same = [](const Near& x, const Near& y) { return x.vertex == y.vertex; };
        near_.erase(std::unique(near_.begin(), near_.end(), same), near_.end());
        if (near_.size() > most_near) near_.resize(most_near);
    }

    void add_star(std::uint32_t v) {
        mesh_.star(v, star_);
        for (const std::uint32_t c : star_) {
            if (std::find(base_.begin(), base_.end(), c) == base_.end()) base_.push_back(c);
        }
    }

    EditMesh& mesh_;
    KeptEdges kept_;
    RecoverOptions options_;
    Cavity cavity_;
    std::optional<Choice> best_;
    std::vector<std::uint32_t> star_, pierced_, base_;
    std::vector<Near> near_;
    std::uint64_t dropped_ = 0;
    std::vector<MeshEdge> made_for_;  // by cell: of those that are new
};

// A subsegment that got a vertex between its ends.
struct Halved {
    std::uint32_t a, b, middle;
};

// Goes over the missing subsegments until none is left or nothing helps; those left stay in `missing`.
std::vector<Halved> recover_all(Recoverer& recoverer, std::vector<Missing>& missing,
                                const RecoverOptions& options, RecoverStats& stats) {
    std::vector<Halved> halved;
    const auto halve = [&](const Missing& subsegment) {
        const std::uint32_t v = recoverer.commit(subsegment.subsegment);
        if (v == no_cell) return v;
        recoverer.keep(subsegment.a, v);
        recoverer.keep(v, subsegment.b);
        halved.push_back({subsegment.a, subsegment.b, v});
        return v;
    };
    // Every other pass splits what the one before could not do.
    for (int pass = 0; pass < 2 * options.passes && !missing.empty(); ++pass) {
        const bool splits = pass % 2 == 1 && options.most_splits > 0;
        std::vector<Missing> left;
        bool done = false;
        for (const Missing& subsegment : missing) {
            if (recoverer.is_edge(subsegment.a, subsegment.b)) continue;
            if (recoverer.recover(subsegment)) {
                stats.without_vertex += halve(subsegment) == no_cell;
                done = true;
            } else if (splits && subsegment.splits < options.most_splits && recoverer.split(subsegment)) {
                const std::uint32_t v = halve(subsegment);
                left.push_back({subsegment.a, v, subsegment.subsegment, subsegment.splits + 1});
                left.push_back({v, subsegment.b, subsegment.subsegment, subsegment.splits + 1});
                done = true;
            } else {
                left.push_back(subsegment);
            }
        }
        missing = std::move(left);
        if (!done && (splits || options.most_splits == 0)) break;
    }
    std::erase_if(missing,
                  [&](const Missing& subsegment) { return recoverer.is_edge(subsegment.a, subsegment.b); });
    return halved;
}

// Subsegments of several structures may have the same ends. `halved` in the order in which it happened.
void add_halves(const std::vector<Halved>& halved, std::vector<Subsegment>& subsegments) {
    for (const auto& [a, b, middle] : halved) {
        const std::size_t count = subsegments.size();
        for (std::size_t n = 0; n < count; ++n) {
            const Subsegment subsegment = subsegments[n];
            if (std::minmax(subsegment.a, subsegment.b) != std::minmax(a, b)) continue;
            subsegments[n].b = middle;
            subsegments.push_back({middle, subsegment.b, subsegment.structure, subsegment.ball});
        }
    }
}

}  // namespace

RecoverResult recover_segments(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                               std::vector<Subsegment>& subsegments, const std::vector<std::uint8_t>& fixed,
                               const RecoverOptions& options) {
    RecoverResult result;
    std::vector<MeshEdge> edges;
    for (const std::uint32_t n :
         missing_subsegments(mesh.cells, mesh.points.size(), subsegments, options.threads))
        edges.push_back(
            {std::min(subsegments[n].a, subsegments[n].b), std::max(subsegments[n].a, subsegments[n].b)});
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    EditMesh edit(std::move(mesh), neighbors);
    Recoverer recoverer(edit, kept_edges(fixed, subsegments), options);
    std::vector<Missing> missing;
    for (const MeshEdge& e : edges) {
        if (!std::binary_search(options.left.begin(), options.left.end(), e))
            missing.push_back({e[0], e[1], e});
    }
    result.stats.missing_before = edges.size();
    const std::vector<Halved> halved = recover_all(recoverer, missing, options, result.stats);
    result.stats.missing_after =
        missing.size() + static_cast<std::size_t>(std::count_if(
                             options.left.begin(), options.left.end(),
                             [&](const MeshEdge& e) { return !recoverer.is_edge(e[0], e[1]); }));
    result.stats.vertices_added = halved.size();
    result.stats.vertices_dropped = recoverer.dropped();
    for (const Halved& subsegment : halved) result.vertices.push_back(subsegment.middle);
    add_halves(halved, subsegments);
    result.made_for = recoverer.made_for();
    result.undecided = take_with_undecided(std::move(edit), mesh, neighbors);
    return result;
}

}  // namespace anatomesh
