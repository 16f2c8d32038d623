#include "anatomesh/sample/sample_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <optional>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/sample/interface_probe.h"
#include "anatomesh/sample/split_encroached_subsegments.h"
#include "anatomesh/sample/thin_walls.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

namespace {

// Two surface points keep this distance. [sizes; 0 to 1; M 2026-11, set not recorded]
constexpr double surface_spacing = 0.6;
// A free point keeps this distance from contour points. [sizes; 0 to 1; M 2026-11, set not recorded]
constexpr double protected_spacing = 0.5;
// Lattice points nearer to an interface than this are moved onto it. [sizes; 0 to 1; M 2026-11, set not recorded]
constexpr double surface_band = 0.45;
// A lattice point is at most so far from its place: ties of position break, shapes stay.
// [half steps; 0 to 0.2; M 2026-11, set not recorded]
constexpr double lattice_shift = 0.04;
// The default size is so many times the root of vertex spacing times slice spacing: thin walls get finer
// points of their own. [1; > 0; M 2026-11 skull]
constexpr double size_per_spacing = 1.05;
// Walls two edges thick in the mean have cells with vertices inside. [mean thicknesses; 0 to 1; M 2026-11 sparse skull]
constexpr double size_per_thickness = 0.49;
// A contact of two contours that is nearer to the end of a segment than this is that end.
// [sizes; 0 to 0.1; M 2026-11 five organs]
constexpr double contact_clearance = 0.01;
// For the sake of contours of other planes subsegments are not split below this.
// [sizes; 0 to 1; M 2026-11 fetal brain]
constexpr double shortest_conforming = 0.025;
// The same about an axis, where segments run beside each other at a few degrees.
// [sizes; 0 to 1; M 2026-11 random sets about an axis]
constexpr double shortest_about_axis = 0.01;
// Where so many segments meet there is an axis: four planes through a line make them. [segments; >= 3; D]
constexpr std::size_t segments_at_pole = 8;
// For the sake of contours of their own slice alone subsegments are not split below this. [sizes; 0 to 1; M 2026-11 spine]
constexpr double shortest_beside_others = 0.1;
// There subsegments are at most so many times as long as the next vertex beside them is far,
// [1; > 0; M 2026-11 16 structures of a head]
constexpr double growth_beside_others = 3;
// down to this length: outlines that are a pixel apart in the mean run hundredths of a millimetre apart in places.
// [sizes; 0 to 1; M 2026-11 16 structures of a head]
constexpr double shortest_graded = 0.015;
// Grading may add so many points for each that there was: outlines that run a tenth of a millimetre beside each other
// all round ask for ten. [1; > 0; M 2026-11 organ drawn twice]
constexpr double most_graded = 20;
// The same where planes cross: more would crowd the cells. [1; > 0; M 2026-11 71 sets of crossing stacks]
constexpr double most_graded_where_planes_cross = 0.5;
// Contour segments are split to this length. [sizes; > 0; M 2026-11, set not recorded]
constexpr double longest_segment = 1.2;
// The slope of the protected lenses on parallel slices: 22 degrees at half the ball. Where planes cross,
// short subsegments lie in each other's balls, and points refused for their lenses left bad cells.
// [1; 0 to 1; M 2026-11 CT labels cut by the border, skull, spine]
constexpr double lens_slope = 0.8;
// Surface points lie on the interface to within this: a tenth of the tolerance of clause 6.
// [sizes; 0 to 0.02; M 2026-11, set not recorded]
constexpr double position_tolerance = 2e-3;

// The body-centred cubic lattice in half steps: the points whose three indices are all even or all odd.
// A point belongs to the lattice 2^L times coarser when its indices are all multiples of 2^(L+1), or all odd
// multiples of 2^L; so coarser lattices are subsets of finer ones.
struct Lattice {
    Vec3 low;
    double step = 1;                             // half the cubic spacing
    std::array<std::uint32_t, 3> size{0, 0, 0};  // points along each axis, in half steps; odd

    // Off its place by a little that depends on the indices alone: an exact lattice has many points on one sphere, or
    // four on one circle, where it changes its spacing, and those make flat cells.
    Vec3 position(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
        const auto shift = [&](std::uint64_t salt) {
            std::uint64_t hash = (i + salt) * 0x9E3779B97F4A7C15ull;
            hash = (hash ^ (hash >> 31)) + j * 0xBF58476D1CE4E5B9ull;
            hash = (hash ^ (hash >> 29)) + k * 0x94D049BB133111EBull;
            hash = (hash ^ (hash >> 32)) * 0xD6E8FEB86659FD93ull;
            return lattice_shift * (static_cast<double>(hash >> 11) * 0x1p-52 - 1.0);
        };
        return low + Vec3{step * (i + shift(1)), step * (j + shift(0x10001)), step * (k + shift(0x200003))};
    }
    // Lattice points in one layer k, row by row; rows hold the points of the layer's parity.
    std::uint32_t row_size(std::uint32_t parity) const { return (size[0] + 1 - parity) / 2; }
    std::uint32_t rows(std::uint32_t parity) const { return (size[1] + 1 - parity) / 2; }
};

int coarsest_level(std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    const int a = i ? std::countr_zero(i) : 31, b = j ? std::countr_zero(j) : 31,
              c = k ? std::countr_zero(k) : 31;
    const int least = std::min({a, b, c});
    return a == b && b == c ? least : least - 1;
}

// Half of the lattice, spread evenly: the diamond lattice. Enough outside, whose cells only serve as room.
bool in_diamond(std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return ((i ^ j ^ k) & 2) == 0;
}

enum class Site : std::uint8_t { outside, inside, near };

struct Sites {
    std::vector<std::size_t> layer_start;  // by k
    std::vector<Site> at;                  // lattice points, layer by layer
};

Sites classify(const Lattice& lattice, const StructureField& field, std::uint32_t structures, double band,
               int threads) {
    Sites sites;
    sites.layer_start.resize(lattice.size[2] + 1, 0);
    for (std::uint32_t k = 0; k < lattice.size[2]; ++k) {
        sites.layer_start[k + 1] =
            sites.layer_start[k] + std::size_t{lattice.row_size(k & 1)} * lattice.rows(k & 1);
    }
    sites.at.resize(sites.layer_start.back());
    parallel_for(lattice.size[2], 1, threads, [&](std::size_t first, std::size_t last) {
        InterfaceProbe probe(field, structures);
        for (std::size_t k = first; k < last; ++k) {
            std::size_t slot = sites.layer_start[k];
            const std::uint32_t parity = k & 1;
            for (std::uint32_t j = parity; j < lattice.size[1]; j += 2) {
                for (std::uint32_t i = parity; i < lattice.size[0]; i += 2) {
                    const Vec3 p = lattice.position(i, j, static_cast<std::uint32_t>(k));
                    const InterfaceProbe::Look there = probe.look(p, band);
                    sites.at[slot++] = there.distance < band   ? Site::near
                                       : there.members.empty() ? Site::outside
                                                               : Site::inside;
                }
            }
        }
    });
    return sites;
}

// Reads the site of any lattice point; outside beyond the lattice.
class SiteReader {
  public:
    SiteReader(const Lattice& lattice, const Sites& sites) : lattice_(lattice), sites_(sites) {}
    Site at(std::int64_t i, std::int64_t j, std::int64_t k) const {
        if (i < 0 || j < 0 || k < 0 || i >= lattice_.size[0] || j >= lattice_.size[1] ||
            k >= lattice_.size[2]) {
            return Site::outside;
        }
        const std::uint32_t parity = k & 1;
        return sites_
            .at[sites_.layer_start[k] + std::size_t(j / 2) * lattice_.row_size(parity) + std::size_t(i / 2)];
    }
    // Whether one of the 8 nearest lattice points is inside or near an interface.
    bool borders(std::int64_t i, std::int64_t j, std::int64_t k) const {
        for (const int d : {-1, 1}) {
            for (const int e : {-1, 1}) {
                for (const int f : {-1, 1}) {
                    if (at(i + d, j + e, k + f) != Site::outside) return true;
                }
            }
        }
        return false;
    }

  private:
    const Lattice& lattice_;
    const Sites& sites_;
};

// For the cubic corners of the lattice: how many cubic steps (largest of the three) to the nearest corner that is
// not deep inside, up to 255. Two sweeps (Borgefors, CVGIP 34, 1986).
class DepthMap {
  public:
    DepthMap(const Lattice& lattice, const SiteReader& sites) {
        for (int a = 0; a < 3; ++a) size_[a] = (lattice.size[a] + 1) / 2;
        depth_.resize(std::size_t{size_[0]} * size_[1] * size_[2]);
        for (std::int64_t k = 0; k < size_[2]; ++k) {
            for (std::int64_t j = 0; j < size_[1]; ++j) {
                for (std::int64_t i = 0; i < size_[0]; ++i) {
                    depth_[index(i, j, k)] = sites.at(2 * i, 2 * j, 2 * k) == Site::inside ? 255 : 0;
                }
            }
        }
        sweep(1);
        sweep(-1);
    }
    // In cubic steps; of the corner nearest below the half-step indices.
    int at(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
        return depth_[index(i / 2, j / 2, k / 2)];
    }

  private:
    std::size_t index(std::int64_t i, std::int64_t j, std::int64_t k) const {
        return static_cast<std::size_t>((k * size_[1] + j) * size_[0] + i);
    }
    int value(std::int64_t i, std::int64_t j, std::int64_t k) const {
        return i < 0 || j < 0 || k < 0 || i >= size_[0] || j >= size_[1] || k >= size_[2]
                   ? 0
                   : depth_[index(i, j, k)];
    }
    void sweep(int sign) {
        const std::int64_t nx = size_[0], ny = size_[1], nz = size_[2];
        for (std::int64_t a = 0; a < nz; ++a) {
            for (std::int64_t b = 0; b < ny; ++b) {
                for (std::int64_t c = 0; c < nx; ++c) {
                    const std::int64_t k = sign > 0 ? a : nz - 1 - a, j = sign > 0 ? b : ny - 1 - b,
                                       i = sign > 0 ? c : nx - 1 - c;
                    std::uint8_t& depth = depth_[index(i, j, k)];
                    if (depth == 0) continue;
                    // The 13 neighbours that the sweep has passed.
                    int least = value(i - sign, j, k);
                    for (int e = -1; e <= 1; ++e) {
                        least = std::min(least, value(i + e, j - sign, k));
                        for (int f = -1; f <= 1; ++f) least = std::min(least, value(i + e, j + f, k - sign));
                    }
                    depth = static_cast<std::uint8_t>(std::min<int>(depth, least + 1));
                }
            }
        }
    }

    std::array<std::uint32_t, 3> size_{};
    std::vector<std::uint8_t> depth_;
};

double contour_length(const ContourSet& contours, const Contour& contour) {
    const auto points = contours.points_of(contour);
    double total = 0;
    for (std::size_t n = 0; n < points.size(); ++n)
        total += length(points[(n + 1) % points.size()] - points[n]);
    return total;
}

// Distinct contour vertices, first appearance first, and the vertex of every point of the set.
void collect_contour_vertices(const ContourSet& contours, PointSample& sample) {
    std::vector<std::uint32_t> order(contours.points.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const Vec3 p = contours.points[a], q = contours.points[b];
        return p == q ? a < b : lexicographic_less(p, q);
    });
    std::vector<std::uint32_t> first(order.size());  // the first point with equal coordinates
    for (std::size_t n = 0; n < order.size(); ++n) {
        const bool repeats = n > 0 && contours.points[order[n]] == contours.points[order[n - 1]];
        first[order[n]] = repeats ? first[order[n - 1]] : order[n];
    }
    sample.contour_vertices.resize(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        if (first[i] == i) {
            sample.contour_vertices[i] = static_cast<std::uint32_t>(sample.points.size());
            sample.points.push_back(contours.points[i]);
        } else {
            sample.contour_vertices[i] = sample.contour_vertices[first[i]];
        }
    }
    sample.stats.contour_points = sample.points.size();
}

// How much finer than the size the subsegments of each segment must be.
std::vector<int> segment_levels(const std::vector<ContourSegment>& segments, const std::vector<Vec3>& points,
                                const StructureField& field, double size, int threads) {
    std::vector<int> levels(segments.size(), 0);
    parallel_for(segments.size(), 256, threads, [&](std::size_t first, std::size_t last) {
        const LocalThickness local_thickness(field, thin_wall * size);
        for (std::size_t n = first; n < last; ++n) {
            const Vec3 middle = 0.5 * (points[segments[n].a] + points[segments[n].b]);
            for (const std::uint32_t structure : segments[n].structures) {
                const auto normal = local_thickness.normal(structure, middle);
                if (normal)
                    levels[n] = std::max(
                        levels[n], level_of(local_thickness.thickness(structure, middle, *normal), size));
            }
        }
    });
    return levels;
}

// Cuts contour segments where they meet those of other structures, and into subsegments short enough.
class SegmentSplitter {
  public:
    SegmentSplitter(double size, bool parallel, PointSample& sample)
        : size_(size),
          sample_(sample),
          protected_segments_(size, 2 * sample.points.size(), parallel ? lens_slope : 0) {}

    // `thin` receives the places where a segment runs along a thin wall.
    ProtectedSegments split(const ContourSet& contours, const StructureField& field, int threads,
                            std::vector<ThinSpot>& thin, bool conforming, bool apart) {
        const std::vector<ContourSegment> segments = distinct_segments(contours, sample_.contour_vertices);
        const std::vector<SegmentCut> cuts =
            cuts_at_contacts(contours, segments, contact_clearance * size_, sample_.points);
        const std::vector<int> levels = segment_levels(segments, sample_.points, field, size_, threads);
        for (const Vec3& p : sample_.points) protected_segments_.add_point(p);
        for (const SegmentPart& part : parts_between(segments, cuts)) {
            int level = 0;
            for (const std::uint32_t s : part.of) level = std::max(level, levels[s]);
            add_subsegments(part.segment, level, thin);
        }
        sample_.has_pole = has_pole();
        // Contours of several structures run side by side within slices too: but for those of a label map,
        // which have the vertices of their common lines in common; and not about an axis, where contours of all
        // slices run side by side at the pole.
        const bool several = contours.structures.size() > 1;
        sample_.graded = several && !contours.exclusive && (conforming ? !sample_.has_pole : apart);
        EncroachmentOptions beside{shortest_beside_others * size_, {}};
        beside.slices = std::move(slices_);
        beside.threads = threads;
        sample_.graded =
            sample_.graded && split_graded(beside, conforming ? most_graded_where_planes_cross : most_graded);
        if (conforming) {
            EncroachmentOptions options{shortest_subsegment() * size_, {}};
            options.threads = threads;
            split_encroached_subsegments(sample_.points, sample_.subsegments, protected_segments_, options);
        } else if (several && apart && !sample_.graded) {
            split_encroached_subsegments(sample_.points, sample_.subsegments, protected_segments_, beside);
        }
        sample_.stats.segment_points = sample_.points.size() - sample_.stats.contour_points;
        return std::move(protected_segments_);
    }

  private:
    // In sizes, where all conform.
    double shortest_subsegment() const {
        return sample_.has_pole ? shortest_about_axis : shortest_conforming;
    }

    bool has_pole() const {
        std::vector<std::array<std::uint32_t, 2>> ends;  // vertex, ball: structures may share a subsegment
        for (const Subsegment& subsegment : sample_.subsegments)
            ends.insert(ends.end(), {{subsegment.a, subsegment.ball}, {subsegment.b, subsegment.ball}});
        sort_distinct(ends);
        std::size_t first = 0;
        for (std::size_t n = 0; n < ends.size(); ++n) {
            if (ends[n][0] != ends[first][0]) first = n;
            if (n - first + 1 >= segments_at_pole) return true;
        }
        return false;
    }

    // Unless that asks for too many points.
    bool split_graded(EncroachmentOptions options, double most) {
        options.growth = growth_beside_others;
        options.shortest_graded_mm = shortest_graded * size_;
        options.most_added = most;
        std::vector<Vec3> points = sample_.points;
        std::vector<Subsegment> subsegments = sample_.subsegments;
        ProtectedSegments protected_segments = protected_segments_;
        const std::size_t added =
            split_encroached_subsegments(points, subsegments, protected_segments, options);
        if (static_cast<double>(added) > most * static_cast<double>(sample_.points.size())) return false;
        sample_.points = std::move(points);
        sample_.subsegments = std::move(subsegments);
        protected_segments_ = std::move(protected_segments);
        return true;
    }

    void add_subsegments(const ContourSegment& segment, int level, std::vector<ThinSpot>& thin) {
        const std::uint32_t a = segment.a, b = segment.b;
        const Vec3 p = sample_.points[a], q = sample_.points[b];
        const int subsegments = std::max(
            1, static_cast<int>(std::ceil(length(q - p) * (1 << level) / (longest_segment * size_))));
        const auto at = [&](int subsegment) {
            return p + (static_cast<double>(subsegment) / subsegments) * (q - p);
        };
        for (int subsegment = 0; level > 0 && subsegment <= subsegments; ++subsegment)
            thin.push_back({at(subsegment), level});
        std::uint32_t from = a;
        for (int subsegment = 1; subsegment < subsegments; ++subsegment) {
            // Another contour has a vertex there already: its own points would come too close.
            if (protected_segments_.any_point_within(at(subsegment), 0.2 * length(q - p) / subsegments))
                continue;
            const auto to = static_cast<std::uint32_t>(sample_.points.size());
            sample_.points.push_back(at(subsegment));
            protected_segments_.add_point(at(subsegment));
            add_subsegment(segment, from, to);
            from = to;
        }
        add_subsegment(segment, from, b);
        slices_.resize(sample_.points.size(), segment.slice);
        slices_[a] = slices_[b] = segment.slice;
    }

    void add_subsegment(const ContourSegment& segment, std::uint32_t from, std::uint32_t to) {
        if (from == to) return;
        const std::uint32_t ball = protected_segments_.add_segment(sample_.points[from], sample_.points[to]);
        for (const std::uint32_t structure : segment.structures)
            sample_.subsegments.push_back({from, to, structure, ball});
    }

    double size_;
    PointSample& sample_;
    ProtectedSegments protected_segments_;
    std::vector<std::uint32_t> slices_;  // by point: the last one that a segment through it lies in
};

struct LatticePoint {
    std::uint32_t i, j, k;
};

// What the free points are placed by.
struct FreePlacement {
    const StructureField& field;
    std::uint32_t structures;                     // of the field
    double size;                                  // the edge length aimed at, in mm
    const ProtectedSegments& protected_segments;  // free points keep out of their balls
    int threads;
};

// Lattice points moved onto interfaces, each kept if it is far enough from those before it.
void add_surface_points(const FreePlacement& place, const Lattice& lattice,
                        const std::vector<LatticePoint>& near, PointGrid& surface, PointSample& sample,
                        std::vector<ThinSpot>& thin) {
    const double size = place.size;
    std::vector<std::optional<Vec3>> moved(near.size());
    std::vector<int> levels(near.size(), 0);
    std::vector<std::uint8_t> allowed(near.size(), 0);
    parallel_for(near.size(), 1024, place.threads, [&](std::size_t first, std::size_t last) {
        InterfaceProbe probe(place.field, place.structures);
        const LocalThickness local_thickness(place.field, thin_wall * size);
        std::vector<std::uint32_t> changed;
        for (std::size_t n = first; n < last; ++n) {
            const Vec3 p = lattice.position(near[n].i, near[n].j, near[n].k);
            moved[n] = probe.project(p, 2.0 * surface_band * size, position_tolerance * size);
            if (!moved[n]) continue;
            if (const auto thickness =
                    thickness_beside(p, *moved[n], local_thickness, probe, place.structures, changed)) {
                levels[n] = level_of(*thickness, size);
            }
            allowed[n] = place.protected_segments.allows(*moved[n], protected_spacing * size);
        }
    });
    for (std::size_t n = 0; n < near.size(); ++n) {
        if (levels[n] > 0) thin.push_back({*moved[n], levels[n]});
        if (!allowed[n] || surface.any_within(*moved[n], surface_spacing * size)) continue;
        surface.add(*moved[n]);
        sample.points.push_back(*moved[n]);
    }
}

// Points on the interfaces about the places where a wall is thin, the finer the thinner it is.
void add_thin_wall_points(const FreePlacement& place, Vec3 low, const std::vector<ThinSpot>& thin,
                          PointGrid& surface, PointSample& sample) {
    const double size = place.size;
    std::vector<std::vector<Vec3>> sites_of_level(max_thin_level);
    parallel_for(sites_of_level.size(), 1, place.threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n)
            sites_of_level[n] = fine_sites(low, thin, max_thin_level - static_cast<int>(n), size);
    });
    for (int level = max_thin_level; level > 0; --level) {
        const double local = size / (1 << level);
        const std::vector<Vec3> sites =
            std::move(sites_of_level[static_cast<std::size_t>(max_thin_level - level)]);
        std::vector<std::optional<Vec3>> moved(sites.size());
        parallel_for(sites.size(), 256, place.threads, [&](std::size_t first, std::size_t last) {
            InterfaceProbe probe(place.field, place.structures);
            const LocalThickness local_thickness(place.field, thin_wall * size);
            std::vector<std::uint32_t> changed;
            for (std::size_t n = first; n < last; ++n) {
                if (probe.look(sites[n], surface_band * local).distance >= surface_band * local) continue;
                moved[n] = probe.project(sites[n], 2.0 * surface_band * local, position_tolerance * local);
                if (!moved[n]) continue;
                if (surface.any_within(*moved[n], surface_spacing * local) ||
                    !place.protected_segments.allows(*moved[n], protected_spacing * local)) {
                    moved[n].reset();
                    continue;
                }
                // A spot's neighbourhood may be thicker than the spot.
                const auto thickness =
                    thickness_beside(sites[n], *moved[n], local_thickness, probe, place.structures, changed);
                if (thickness && level_of(0.8 * *thickness, size) < level) moved[n].reset();
            }
        });
        for (const std::optional<Vec3>& p : moved) {
            if (!p || surface.any_within(*p, surface_spacing * local)) continue;
            surface.add(*p);
            sample.points.push_back(*p);
        }
    }
}

void add_lattice_points(const FreePlacement& place, const Lattice& lattice, const Sites& sites, double growth,
                        const PointGrid& surface, PointSample& sample) {
    const SiteReader reader(lattice, sites);
    const DepthMap depths(lattice, reader);
    std::vector<std::vector<Vec3>> layers(lattice.size[2]);
    const auto add_layer = [&](std::uint32_t k) {
        const std::uint32_t parity = k & 1;
        for (std::uint32_t j = parity; j < lattice.size[1]; j += 2) {
            for (std::uint32_t i = parity; i < lattice.size[0]; i += 2) {
                const Site site = reader.at(i, j, k);
                if (site == Site::near ||
                    (site == Site::outside && !(in_diamond(i, j, k) && reader.borders(i, j, k))))
                    continue;
                if (site == Site::inside) {
                    // Deep inside only the points of a coarser lattice are kept.
                    const double wanted = 1.0 + growth * std::max(0, depths.at(i, j, k) - 2);
                    if ((1 << (coarsest_level(i, j, k) + 1)) <= wanted) continue;
                }
                const Vec3 p = lattice.position(i, j, k);
                if (surface.any_within(p, protected_spacing * place.size) ||
                    !place.protected_segments.allows(p, protected_spacing * place.size))
                    continue;
                layers[k].push_back(p);
            }
        }
    };
    parallel_for(lattice.size[2], 1, place.threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) add_layer(static_cast<std::uint32_t>(k));
    });
    const std::size_t before = sample.points.size();
    for (const std::vector<Vec3>& layer : layers)
        sample.points.insert(sample.points.end(), layer.begin(), layer.end());
    sample.stats.lattice_points = sample.points.size() - before;
}

void add_frame(const Box3& box, PointSample& sample) {
    const Box3 frame = box.grown(box.diagonal());
    for (int corner = 0; corner < 8; ++corner) {
        sample.points.push_back({corner & 1 ? frame.high.x : frame.low.x,
                                 corner & 2 ? frame.high.y : frame.low.y,
                                 corner & 4 ? frame.high.z : frame.low.z});
    }
    sample.stats.frame_points = 8;
}

}  // namespace

std::vector<double> mean_thickness(const ContourSet& contours) {
    std::vector<double> area(contours.structures.size(), 0), perimeter(contours.structures.size(), 0);
    for (const Contour& contour : contours.contours) {
        const Plane& plane = contours.slices[contour.slice].plane;
        const auto points = contours.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n) {
            const Vec2 p = plane.to_plane(points[n]), q = plane.to_plane(points[(n + 1) % points.size()]);
            area[contour.structure] += 0.5 * cross(p, q);
            perimeter[contour.structure] += length(q - p);
        }
    }
    for (std::size_t s = 0; s < area.size(); ++s) area[s] = perimeter[s] > 0 ? 2 * area[s] / perimeter[s] : 0;
    return area;
}

bool dense_planes(const ContourSet& contours, const SliceArrangement& arrangement,
                  const StructureField& field) {
    return plane_density(contours, arrangement, field) > 1;
}

double plane_density(const ContourSet& contours, const SliceArrangement& arrangement,
                     const StructureField& field) {
    if (arrangement.is_parallel()) return 0;
    return mean_vertex_spacing(contours) / (dense_spacing * field.slice_spacing());
}

double default_size(const ContourSet& contours, const SliceArrangement& arrangement,
                    const StructureField& field) {
    std::vector<double> perimeter(contours.structures.size(), 0);
    for (const Contour& contour : contours.contours)
        perimeter[contour.structure] += contour_length(contours, contour);
    const std::vector<double> thickness = mean_thickness(contours);
    double total = 0, thick = 0;
    for (std::size_t s = 0; s < perimeter.size(); ++s) {
        total += perimeter[s];
        thick += perimeter[s] * thickness[s];
    }
    const double vertex_spacing = mean_vertex_spacing(contours);
    double spacing = field.slice_spacing();
    if (dense_planes(contours, arrangement, field)) {
        const double denser = vertex_spacing / (dense_spacing * spacing);
        spacing *= std::min(denser * denser, dense_spacing * dense_spacing * denser);
    }
    const double size =
        std::clamp(size_per_spacing * std::sqrt(vertex_spacing * spacing), 0.5 * spacing, 2 * spacing);
    if (!(thick > 0)) return size;
    const double mean = thick / total;
    return std::min({size, mean, std::max(spacing, size_per_thickness * mean)});
}

Result<PointSample> sample_points(const ContourSet& contours, const SliceArrangement& arrangement,
                                  const StructureField& field, const SampleOptions& options,
                                  RunContext& context) {
    const double size = options.size_mm > 0 ? options.size_mm : default_size(contours, arrangement, field);
    PointSample sample{{}, {}, {}, ProtectedSegments(size, 0), false, false, {}};
    sample.stats.size_mm = size;

    // The lattice, two steps larger than the box of the field on every side.
    const Box3 box = field.box().grown(2 * size);
    Lattice lattice{box.low, 0.5 * size, {}};
    const std::array<double, 3> extent{box.high.x - box.low.x, box.high.y - box.low.y,
                                       box.high.z - box.low.z};
    double needed = 0.25;
    for (const double e : extent) needed *= e / lattice.step;
    for (const Contour& contour : contours.contours) needed += contour_length(contours, contour) / size;
    if (!(needed <= static_cast<double>(options.max_points))) {
        return Error{ErrorKind::limit,
                     "E-SMP-001",
                     "an edge length of " + brief(size) + " mm would need about " + brief(needed) +
                         " points, more than " + std::to_string(options.max_points),
                     {},
                     "give a larger --size"};
    }
    collect_contour_vertices(contours, sample);
    std::vector<ThinSpot> thin;
    sample.protected_segments =
        SegmentSplitter(size, arrangement.is_parallel(), sample)
            .split(contours, field, context.threads, thin, options.conforming, arrangement.is_stack());
    for (int a = 0; a < 3; ++a) lattice.size[a] = 2 * static_cast<std::uint32_t>(extent[a] / size) + 1;

    const std::uint32_t structures = static_cast<std::uint32_t>(contours.structures.size());
    // Distances end at the clamp: what is as far off may be anywhere.
    const double band = std::min(surface_band * size, 0.9 * field.clamp());
    const Sites sites = classify(lattice, field, structures, band, context.threads);
    if (context.cancelled()) return cancelled_error();

    std::vector<LatticePoint> near;
    const SiteReader reader(lattice, sites);
    for (std::uint32_t k = 0; k < lattice.size[2]; ++k) {
        for (std::uint32_t j = k & 1; j < lattice.size[1]; j += 2) {
            for (std::uint32_t i = k & 1; i < lattice.size[0]; i += 2) {
                if (reader.at(i, j, k) == Site::near) near.push_back({i, j, k});
            }
        }
    }
    PointGrid surface(surface_spacing * size, near.size());
    const FreePlacement place{field, structures, size, sample.protected_segments, context.threads};
    add_surface_points(place, lattice, near, surface, sample, thin);
    add_thin_wall_points(place, lattice.low, thin, surface, sample);
    sample.stats.surface_points = surface.size();
    sample.stats.thin_spots = thin.size();
    add_lattice_points(place, lattice, sites, options.growth, surface, sample);
    add_frame(box, sample);
    return sample;
}

}  // namespace anatomesh
