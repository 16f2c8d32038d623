#include "anatomesh/mesh/stars/star.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <utility>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// Cells are counted by no more threads at once, because each takes memory for every vertex.
// [threads; >= 1; B]
constexpr int most_runs = 16;

// What belongs to each vertex, rising and once: that of vertex v is items[start[v], start[v + 1]).
// visit(emit) must call emit(vertex, item) for the same sequence each time it is called. Count, scan, fill,
// then sort the few of every vertex.
template <class T, class Visit>
void file_by_vertex(std::size_t point_count, const Visit& visit, std::vector<std::uint32_t>& start,
                    std::vector<T>& items) {
    start.assign(point_count + 1, 0);
    visit([&](std::uint32_t vertex, const T&) { ++start[vertex + 1]; });
    std::partial_sum(start.begin(), start.end(), start.begin());
    items.resize(start[point_count]);
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
    visit([&](std::uint32_t vertex, const T& item) { items[next[vertex]++] = item; });
    auto kept = items.begin();
    for (std::size_t v = 0; v < point_count; ++v) {
        const auto first = items.begin() + start[v], last = items.begin() + start[v + 1];
        std::sort(first, last);
        start[v] = static_cast<std::uint32_t>(kept - items.begin());
        kept = std::copy(first, std::unique(first, last), kept);
    }
    start[point_count] = static_cast<std::uint32_t>(kept - items.begin());
    items.erase(kept, items.end());
}

}  // namespace

// Every thread has a run of the cells: what it counts tells where its own cells go in each star.
VertexStars::VertexStars(std::span<const Cell> cells, std::size_t point_count, int threads)
    : start_(point_count + 1, 0) {
    const std::size_t runs = static_cast<std::size_t>(std::clamp(threads, 1, most_runs)),
                      grain = std::max<std::size_t>(1, (cells.size() + runs - 1) / runs);
    std::vector<std::vector<std::uint32_t>> next(runs, std::vector<std::uint32_t>(point_count, 0));
    parallel_for(cells.size(), grain, threads, [&](std::size_t first, std::size_t last) {
        std::vector<std::uint32_t>& count = next[first / grain];
        for (std::size_t c = first; c < last; ++c) {
            for (const std::uint32_t v : cells[c]) ++count[v];
        }
    });
    std::uint32_t sum = 0;
    for (std::size_t v = 0; v < point_count; ++v) {
        start_[v] = sum;
        for (std::vector<std::uint32_t>& run : next) sum += std::exchange(run[v], sum);
    }
    start_[point_count] = sum;
    cells_.resize(4 * cells.size());
    parallel_for(cells.size(), grain, threads, [&](std::size_t first, std::size_t last) {
        std::vector<std::uint32_t>& place = next[first / grain];
        for (std::size_t c = first; c < last; ++c) {
            for (const std::uint32_t v : cells[c]) cells_[place[v]++] = static_cast<std::uint32_t>(c);
        }
    });
}

ContourOwners::ContourOwners(const std::vector<std::array<std::uint32_t, 2>>& vertices,
                             std::size_t point_count,
                             const std::vector<std::array<std::uint32_t, 3>>& subsegments) {
    const auto each_vertex = [&](const auto& emit) {
        for (const auto& [vertex, structure] : vertices) emit(vertex, structure);
    };
    const auto each_end = [&](const auto& emit) {
        for (const auto& [a, b, structure] : subsegments) {
            emit(a, Subsegment{b, structure});
            emit(b, Subsegment{a, structure});
        }
    };
    file_by_vertex(point_count, each_vertex, start_, structures_);
    file_by_vertex(point_count, each_end, subsegment_start_, subsegments_);
}

bool ContourOwners::has(std::uint32_t vertex, std::uint32_t structure) const {
    const auto owners = at(vertex);
    const auto subsegments = subsegments_at(vertex);
    return std::find(owners.begin(), owners.end(), structure) != owners.end() ||
           std::any_of(subsegments.begin(), subsegments.end(),
                       [&](Subsegment s) { return s.structure == structure; });
}

StarAnalyzer::StarAnalyzer(const std::vector<Cell>& cells, const std::vector<CellNeighbors>& neighbors,
                           const VertexStars& stars, const std::vector<Region>& regions,
                           const RegionTable& table, const ContourOwners& owners)
    : cells_(cells),
      neighbors_(neighbors),
      stars_(stars),
      regions_(regions),
      table_(table),
      owners_(owners),
      local_(cells.size(), 0) {}

void StarAnalyzer::load(std::uint32_t vertex) {
    star_ = stars_.at(vertex);
    kinds_.clear();
    kind_.resize(star_.size());
    for (std::uint32_t n = 0; n < star_.size(); ++n) {
        local_[star_[n]] = n;
        const Region region = regions_[star_[n]];
        std::size_t k = 0;
        while (k < kinds_.size() && kinds_[k] != region) ++k;
        if (k == kinds_.size() && k < 64) kinds_.push_back(region);
        kind_[n] = static_cast<std::uint8_t>(std::min<std::size_t>(k, 63));
    }
    cuts_.clear();
    cut_body_.clear();
    if (kinds_.size() < 2) return;
    adjacent_.resize(star_.size());
    for (std::uint32_t n = 0; n < star_.size(); ++n) {
        int side = 0;
        for (int i = 0; i < 4; ++i) {
            if (cells_[star_[n]][i] == vertex) continue;
            const std::uint32_t across = neighbors_[star_[n]][i];
            adjacent_[n][side++] = across == no_cell ? n : local_[across];
        }
    }
    find_cuts();
}

// Every region of the star cuts it, and so does every structure in some but not all of them; equal cuts are kept once.
void StarAnalyzer::find_cuts() {
    for (const Region kind : kinds_) add_cut({true, kind});
    if (kinds_.size() == 2) return;  // any structure cuts as the regions do
    for (const Region kind : kinds_) {
        for (const std::uint32_t structure : table_.members[kind]) add_cut({false, structure});
    }
}

void StarAnalyzer::add_cut(Body body) {
    std::uint64_t cut = 0;
    for (std::size_t k = 0; k < kinds_.size(); ++k) {
        if (body.holds(table_, kinds_[k])) cut |= std::uint64_t{1} << k;
    }
    const std::uint64_t all = (std::uint64_t{1} << kinds_.size()) - 1;
    if (cut == all) return;
    for (const std::uint64_t known : cuts_) {
        if (known == cut || known == (all & ~cut)) return;
    }
    cuts_.push_back(cut);
    cut_body_.push_back(body);
}

// Numbers the components of one cut in component_ and returns how many there are.
int StarAnalyzer::count_components(std::uint32_t cut) {
    // It stands for a cell without a component so far. [index; 2^32 - 1; D]
    constexpr std::uint32_t none = 0xFFFFFFFFu;
    component_.assign(star_.size(), none);
    int components = 0;
    for (std::uint32_t seed = 0; seed < star_.size(); ++seed) {
        if (component_[seed] != none) continue;
        stack_.assign(1, seed);
        component_[seed] = static_cast<std::uint32_t>(components);
        const std::uint64_t side = cuts_[cut] >> kind_[seed] & 1;
        while (!stack_.empty()) {
            const std::uint32_t n = stack_.back();
            stack_.pop_back();
            for (const std::uint32_t m : adjacent_[n]) {
                if (component_[m] != none || (cuts_[cut] >> kind_[m] & 1) != side) continue;
                component_[m] = static_cast<std::uint32_t>(components);
                stack_.push_back(m);
            }
        }
        ++components;
    }
    return components;
}

int StarAnalyzer::singularity_count(std::uint32_t vertex) {
    load(vertex);
    int sum = 0;
    for (std::uint32_t cut = 0; cut < cuts_.size(); ++cut) sum += count_components(cut) - 2;
    for (const std::uint32_t structure : owners_.at(vertex)) {
        bool in = false, out = false;
        for (const Region kind : kinds_) (table_.contains(kind, structure) ? in : out) = true;
        if (!(in && out)) sum += lost_vertex_weight;
    }
    return sum;
}

// Whether all cells round the edge lie on one side of the structure. An edge that is not in the mesh is not looked at.
bool StarAnalyzer::subsegment_lost(std::uint32_t vertex, ContourOwners::Subsegment subsegment) const {
    bool in = false, out = false;
    for (const std::uint32_t c : stars_.at(vertex)) {
        const Cell& cell = cells_[c];
        if (cell[0] != subsegment.other && cell[1] != subsegment.other && cell[2] != subsegment.other &&
            cell[3] != subsegment.other)
            continue;
        (table_.contains(regions_[c], subsegment.structure) ? in : out) = true;
    }
    return in != out;
}

int StarAnalyzer::lost_subsegment_count(std::uint32_t vertex) {
    int count = 0;
    for (const ContourOwners::Subsegment& subsegment : owners_.subsegments_at(vertex))
        count += subsegment_lost(vertex, subsegment);
    return count;
}

void StarAnalyzer::lost_subsegments(std::uint32_t vertex,
                                    std::vector<ContourOwners::Subsegment>& subsegments) {
    subsegments.clear();
    for (const ContourOwners::Subsegment& subsegment : owners_.subsegments_at(vertex)) {
        if (subsegment_lost(vertex, subsegment)) subsegments.push_back(subsegment);
    }
}

void StarAnalyzer::surplus_components(std::uint32_t vertex, std::vector<StarComponent>& components) {
    components.clear();
    load(vertex);
    for (std::uint32_t cut = 0; cut < cuts_.size(); ++cut) {
        const int count = count_components(cut);
        if (count <= 2) continue;
        std::vector<StarComponent> found(count);
        for (std::uint32_t n = 0; n < star_.size(); ++n) {
            StarComponent& component = found[component_[n]];
            component.body = cut_body_[cut];
            component.inside = cuts_[cut] >> kind_[n] & 1;
            component.cells.push_back(star_[n]);
        }
        for (const bool inside : {false, true}) {
            std::size_t largest = found.size(), on_side = 0;
            for (std::size_t n = 0; n < found.size(); ++n) {
                if (found[n].inside != inside) continue;
                ++on_side;
                if (largest == found.size() || found[n].cells.size() > found[largest].cells.size())
                    largest = n;
            }
            if (on_side < 2) continue;
            found[largest].largest = true;
            for (const StarComponent& component : found) {
                if (component.inside == inside) components.push_back(component);
            }
        }
    }
}

void StarAnalyzer::lost_structures(std::uint32_t vertex, std::vector<std::uint32_t>& structures) {
    structures.clear();
    load(vertex);
    for (const std::uint32_t structure : owners_.at(vertex)) {
        bool in = false, out = false;
        for (const Region kind : kinds_) (table_.contains(kind, structure) ? in : out) = true;
        if (!(in && out)) structures.push_back(structure);
    }
}

}  // namespace anatomesh
