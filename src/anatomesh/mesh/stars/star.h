// Star analysis: into how many components the structures at a vertex cut the cells round it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

using CellNeighbors = std::array<std::uint32_t, 4>;

// The cells at every vertex, cells in rising order. Complexity: O(cells) time; memory beside the stars: one number
// for every point and thread.
class VertexStars {
  public:
    VertexStars(std::span<const Cell> cells, std::size_t point_count, int threads = 1);
    std::span<const std::uint32_t> at(std::uint32_t vertex) const {
        return {cells_.data() + start_[vertex], start_[vertex + 1] - start_[vertex]};
    }

  private:
    std::vector<std::uint32_t> start_, cells_;
};

// The structures whose contours have a vertex at a mesh vertex, or a segment along a mesh edge: they must have it on their
// surface.
class ContourOwners {
  public:
    // A subsegment, seen from one of its ends.
    struct Subsegment {
        std::uint32_t other, structure;
        friend auto operator<=>(const Subsegment&, const Subsegment&) = default;
    };

    ContourOwners() = default;
    // vertices: pairs (vertex, structure); subsegments: triples (vertex, vertex, structure). In any order,
    // repeats allowed.
    ContourOwners(const std::vector<std::array<std::uint32_t, 2>>& vertices, std::size_t point_count,
                  const std::vector<std::array<std::uint32_t, 3>>& subsegments = {});
    std::span<const std::uint32_t> at(std::uint32_t vertex) const {
        if (vertex + 1 >= start_.size()) return {};
        return {structures_.data() + start_[vertex], start_[vertex + 1] - start_[vertex]};
    }
    std::span<const Subsegment> subsegments_at(std::uint32_t vertex) const {
        if (vertex + 1 >= subsegment_start_.size()) return {};
        return {subsegments_.data() + subsegment_start_[vertex],
                subsegment_start_[vertex + 1] - subsegment_start_[vertex]};
    }

    bool knows(std::uint32_t vertex) const { return vertex + 1 < start_.size(); }
    // Whether a contour of the structure has a vertex there, or the end of a subsegment.
    bool has(std::uint32_t vertex, std::uint32_t structure) const;

  private:
    std::vector<std::uint32_t> start_, structures_, subsegment_start_;
    std::vector<Subsegment> subsegments_;
};

// A set of regions whose surface must be a manifold: all regions of one structure, or one region by itself (region 0,
// the outside, stands for the union of all structures).
struct Body {
    bool is_region = false;
    std::uint32_t index = 0;  // of the structure, or the region

    bool holds(const RegionTable& table, Region region) const {
        return is_region ? region == index : table.contains(region, index);
    }
};

// One component of a star: facet-connected cells on one side of one body (or of several that cut the star
// alike).
struct StarComponent {
    Body body;             // one body that makes this cut
    bool inside = false;   // whether the component lies in it
    bool largest = false;  // of its side
    std::vector<std::uint32_t> cells;
};

// A contour vertex off its structure's surface counts as so many surplus components: it is worth more than a simpler
// star. [components; >= 1; M 2026-11, set not recorded]
inline constexpr int lost_vertex_weight = 3;

// Looks at stars of a mesh whose regions change under it. Keeps scratch space: not thread-safe.
// A vertex is *manifold* when every body cuts its star into at most one component inside and one outside (then
// the body's surface passes through it as one disc or not at all: no non-manifold edge or vertex there) and
// every structure with a contour vertex there has it on its surface. Subsegments off the surface are
// counted apart and make no vertex non-manifold.
class StarAnalyzer {
  public:
    StarAnalyzer(const std::vector<Cell>& cells, const std::vector<CellNeighbors>& neighbors,
                 const VertexStars& stars, const std::vector<Region>& regions, const RegionTable& table,
                 const ContourOwners& owners);

    // 0 for a manifold vertex, else the number of components too many, plus `lost_vertex_weight` for each structure
    // with a contour vertex here that is not on its surface.
    int singularity_count(std::uint32_t vertex);

    // The subsegments at the vertex that are edges of the mesh but not of their structure's surface,
    // both ends counted: a sum over vertices counts each twice.
    int lost_subsegment_count(std::uint32_t vertex);
    void lost_subsegments(std::uint32_t vertex, std::vector<ContourOwners::Subsegment>& subsegments);

    // Components of those sides that have more than one. Empty for a vertex without surplus components.
    void surplus_components(std::uint32_t vertex, std::vector<StarComponent>& components);

    // Structures with a contour vertex here that do not have it on their surface.
    void lost_structures(std::uint32_t vertex, std::vector<std::uint32_t>& structures);

  private:
    void load(std::uint32_t vertex);
    bool subsegment_lost(std::uint32_t vertex, ContourOwners::Subsegment subsegment) const;
    void find_cuts();
    void add_cut(Body body);
    int count_components(std::uint32_t cut);

    const std::vector<Cell>& cells_;
    const std::vector<CellNeighbors>& neighbors_;
    const VertexStars& stars_;
    const std::vector<Region>& regions_;
    const RegionTable& table_;
    const ContourOwners& owners_;

    std::span<const std::uint32_t> star_;
    std::vector<std::uint32_t> local_;  // by cell: position in the star
    std::vector<std::array<std::uint32_t, 3>>
        adjacent_;                                  // by position: positions across facets at the vertex
    std::vector<Region> kinds_;                     // distinct regions of the star
    std::vector<std::uint8_t> kind_;                // by position
    std::vector<std::uint64_t> cuts_;               // distinct partitions: bit n = kinds_[n] is inside
    std::vector<Body> cut_body_;                    // one body that makes each
    std::vector<std::uint32_t> component_, stack_;  // by position; scratch
};

}  // namespace anatomesh
