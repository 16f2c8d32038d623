#include "anatomesh/cut/spurious_components.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

namespace {

constexpr std::size_t most_cells = 64;  // A spurious component has no more. [cells; >= 1; B]

class SpuriousComponentSearch {
  public:
    SpuriousComponentSearch(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                            std::span<const std::uint8_t> given, double most_mm3)
        : mesh_(mesh),
          neighbors_(neighbors),
          given_(given),
          most_mm3_(most_mm3),
          state_(mesh.cells.size(), State::unknown) {}

    // Whether the component at the cell, not looked at yet, is a spurious component: component() and beyond()
    // then.
    bool found(std::uint32_t cell) {
        if (state_[cell] != State::unknown || !may_be_in_one(cell)) return false;
        component_ = {cell};
        state_[cell] = State::in_component;
        const bool whole = grow();
        for (const std::uint32_t c : component_) state_[c] = State::known;
        if (whole) find_beyond();
        return whole && !beyond_.empty();
    }

    // Whether the cell alone does not rule a spurious component that begins with it out.
    bool may_be_in_one(std::uint32_t c) const {
        return on_interface(c) && !is_drawn(c) && volume(c) <= most_mm3_;
    }

    const std::vector<std::uint32_t>& component() const { return component_; }

    // The regions round the component, that with the largest area in common first.
    const std::vector<Region>& beyond() const { return beyond_; }

  private:
    enum class State : std::uint8_t { unknown, in_component, known };

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

    // Over facets, until the component ends; not where it is too large, has a contour's vertex, reaches the
    // end of the mesh, or joins what was found to.
    bool grow() {
        double total = 0;
        for (std::size_t n = 0; n < component_.size(); ++n) {
            const std::uint32_t c = component_[n];
            total += volume(c);
            if (total > most_mm3_ || component_.size() > most_cells || is_drawn(c)) return false;
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t next = neighbors_[4 * std::size_t{c} + i];
                if (next == no_cell) return false;
                if (differs(next, c) || state_[next] == State::in_component) continue;
                if (state_[next] == State::known) return false;
                state_[next] = State::in_component;
                component_.push_back(next);
            }
        }
        return true;
    }

    void find_beyond() {
        std::vector<std::pair<Region, double>> areas;
        for (const std::uint32_t c : component_) {
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t next = neighbors_[4 * std::size_t{c} + i];
                if (!differs(next, c)) continue;
                const Region region = mesh_.regions[next];
                const auto known = std::find_if(areas.begin(), areas.end(),
                                                [&](const auto& each) { return each.first == region; });
                if (known != areas.end()) {
                    known->second += facet_area(c, i);
                } else {
                    areas.push_back({region, facet_area(c, i)});
                }
            }
        }
        std::sort(areas.begin(), areas.end(), [](const auto& a, const auto& b) {
            return a.second != b.second ? a.second > b.second : a.first < b.first;
        });
        beyond_.clear();
        for (const auto& [region, area] : areas) beyond_.push_back(region);
    }

    double facet_area(std::uint32_t c, int opposite) const {
        std::array<Vec3, 3> p;
        for (std::size_t k = 0, n = 0; k < 4; ++k) {
            if (k != static_cast<std::size_t>(opposite)) p[n++] = mesh_.points[mesh_.cells[c][k]];
        }
        return 0.5 * length(cross(p[1] - p[0], p[2] - p[0]));
    }

    const TetMesh& mesh_;
    std::span<const std::uint32_t> neighbors_;
    std::span<const std::uint8_t> given_;
    double most_mm3_;
    std::vector<State> state_;
    std::vector<std::uint32_t> component_;
    std::vector<Region> beyond_;
};

// A mesh as the analyzer wants it.
struct Stars {
    Stars(const TetMesh& mesh, std::span<const std::uint32_t> flat, const RegionTable& regions, int threads)
        : neighbors(mesh.cells.size()),
          at(mesh.cells, mesh.points.size(), threads),
          analyzer(mesh.cells, neighbors, at, mesh.regions, regions, owners) {
        for (std::size_t c = 0; c < neighbors.size(); ++c)
            std::copy_n(flat.begin() + static_cast<std::ptrdiff_t>(4 * c), 4, neighbors[c].begin());
    }
    std::vector<CellNeighbors> neighbors;
    VertexStars at;
    ContourOwners owners;  // no spurious component has their vertices
    StarAnalyzer analyzer;
};

bool are_sound(const TetMesh& mesh, const std::vector<std::uint32_t>& cells, StarAnalyzer& stars) {
    return std::all_of(cells.begin(), cells.end(), [&](std::uint32_t c) {
        const Cell& cell = mesh.cells[c];
        return std::all_of(cell.begin(), cell.end(),
                           [&](std::uint32_t v) { return stars.singularity_count(v) == 0; });
    });
}

// Whether the component took one of the regions round it.
bool is_relabelled(TetMesh& mesh, const std::vector<std::uint32_t>& component,
                   const std::vector<Region>& beyond, StarAnalyzer* stars) {
    if (beyond.size() > 1 && stars == nullptr) return false;
    const Region own = mesh.regions[component.front()];
    for (const Region region : beyond) {
        for (const std::uint32_t c : component) mesh.regions[c] = region;
        if (beyond.size() == 1 || are_sound(mesh, component, *stars)) return true;
    }
    for (const std::uint32_t c : component) mesh.regions[c] = own;
    return false;
}

}  // namespace

SpuriousComponentStats remove_spurious_components(TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                                  std::span<const std::uint8_t> given,
                                                  const SpuriousComponentOptions& options, int threads,
                                                  const RegionTable* regions) {
    std::optional<Stars> stars;
    if (regions != nullptr) stars.emplace(mesh, neighbors, *regions, threads);
    SpuriousComponentStats stats;
    SpuriousComponentSearch search(mesh, neighbors, given, options.most_mm3);
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
        if (!is_relabelled(mesh, search.component(), search.beyond(), stars ? &stars->analyzer : nullptr))
            continue;
        ++stats.components;
        stats.cells += search.component().size();
    }
    return stats;
}

}  // namespace anatomesh
