#include "anatomesh/field/planes/patch_grid.h"

#include <cmath>
#include <utility>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// Among so few patches hidden ones cost nothing, and none is looked for. [patches; >= 2; B]
constexpr std::size_t few_listed = 6;

}  // namespace

PatchGrid::PatchGrid(std::vector<PlanePatch> patches, const std::vector<std::uint32_t>& drawn,
                     const Box3& box, double radius, double margin, int threads)
    : patches_(std::move(patches)), box_(box), radius_(radius), margin_(margin) {
    // The grid has no more cells; beyond it they grow. [cells; >= 1; B]
    constexpr double most_cells = 1 << 18;
    const Vec3 size = box_.high - box_.low;
    const double cell = std::max(0.5 * radius_, std::cbrt(size.x * size.y * size.z / most_cells));
    inverse_cell_ = 1 / cell;
    const std::array<double, 3> sizes{size.x, size.y, size.z};
    for (std::size_t a = 0; a < 3; ++a) cells_[a] = static_cast<std::uint32_t>(sizes[a] * inverse_cell_) + 1;
    list_patches(drawn, cell, threads);
}

// The nearest patch on either side of those before which p lies, but for one.
std::array<PatchGrid::Occluder, 2> PatchGrid::occluders_at(Vec3 p, std::span<const Listed> listed,
                                                           std::uint32_t but) const {
    std::array<Occluder, 2> occluders;
    for (const Listed& one : listed) {
        if (!one.before || one.patch == but) continue;
        const Plane& plane = patches_[one.patch].plane;
        const double height = plane.signed_distance(p);
        Occluder& occluder = occluders[(height > 0) != (one.against == 1)];
        if (occluder.height == 0 || std::abs(height) < std::abs(occluder.height))
            occluder = {one.patch, height, plane.normal};
    }
    return occluders;
}

// The nearest patches within the radius, sorted by distance, but for one and most of those that nearer ones
// hide.
std::uint32_t PatchGrid::find_near(Vec3 p, Keys& keys, std::uint32_t but) const {
    if (!box_.contains(p)) return 0;
    const Vec3 at = inverse_cell_ * (p - box_.low);
    const auto index = [](double v, std::uint32_t n) {
        return std::min(static_cast<std::uint32_t>(v), n - 1);
    };
    const std::size_t cell =
        (static_cast<std::size_t>(index(at.z, cells_[2])) * cells_[1] + index(at.y, cells_[1])) * cells_[0] +
        index(at.x, cells_[0]);
    const std::span<const Listed> listed{cell_patches_.data() + cell_begin_[cell],
                                         cell_patches_.data() + cell_begin_[cell + 1]};
    const std::array<Occluder, 2> occluders =
        listed.size() > few_listed ? occluders_at(p, listed, but) : std::array<Occluder, 2>{};
    std::uint32_t count = 0;
    double farthest = radius_ * radius_;
    for (const Listed& one : listed) {
        if (one.patch == but) continue;
        const PlanePatch& patch = patches_[one.patch];
        const double height = patch.plane.signed_distance(p);
        const double across = std::clamp(height, patch.low, patch.high) - height;
        if (across * across >= farthest) continue;
        const auto is_hidden_by = [&](const Occluder& occluder) {
            return occluder.hides(one.patch, across, patch.plane.normal);
        };
        if (one.before && (is_hidden_by(occluders[0]) || is_hidden_by(occluders[1]))) continue;
        const Vec2 way = one.before ? Vec2{} : way_to(patch, patch.plane.to_plane(p));
        const double square = squared_length(way) + across * across;
        if (square >= farthest) continue;
        std::uint32_t place = count == most_near ? most_near - 1 : count++;
        for (; place > 0 && keys[place - 1].square > square; --place) keys[place] = keys[place - 1];
        keys[place] = {square, one.patch};
        if (count == most_near) farthest = keys[most_near - 1].square;
    }
    return count;
}

// Whether for every point of a cell the way to the further patch leads through the nearer one: then its share
// is nothing (share_of), also where the nearer one is hidden itself. The heights are linear over the cell.
bool PatchGrid::is_hidden(const Beside& far, const Beside& near, double half) const {
    const Vec3 m = patches_[near.patch].plane.normal, n = patches_[far.patch].plane.normal;
    const double along = dot(m, n);
    const Vec3 change = along * n - m;
    const double beyond = far.distance * along - near.height;
    return (near.height > 0 ? beyond : -beyond) >=
           half * (std::abs(change.x) + std::abs(change.y) + std::abs(change.z));
}

// Whether all points within `reach` of p project into the grown patch.
bool PatchGrid::is_before(Vec3 p, double reach, const PlanePatch& patch) const {
    const Vec2 foot = patch.plane.to_plane(p);
    const double inside = std::min({foot.x - patch.box.low.x, patch.box.high.x - foot.x,
                                    foot.y - patch.box.low.y, patch.box.high.y - foot.y});
    return inside + margin_ >= reach;
}

// Leaves out those of a cell's patches that count nowhere in it.
void PatchGrid::drop_hidden(Vec3 center, double half, std::vector<std::uint32_t>& list,
                            std::vector<Beside>& beside) const {
    // So many of the nearest patches are asked whether they hide others: further ones hide little more.
    // [patches; >= 2; B]
    constexpr std::size_t most_hiders = 4;
    std::array<Beside, most_hiders> occluders;
    std::size_t count = 0;
    const double diagonal = std::sqrt(3.0) * half;
    beside.clear();
    for (const std::uint32_t n : list) {
        const PlanePatch& patch = patches_[n];
        const Vec3 normal = patch.plane.normal;
        const double height = patch.plane.signed_distance(center);
        const double distance =
            height - std::clamp(height, std::min(patch.low, 0.0), std::max(patch.high, 0.0));
        beside.push_back(
            {n, height, distance,
             is_before(center, diagonal, patch) &&
                 std::abs(distance) > half * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z))});
    }
    // The nearest hide most: the nearest of all, the nearest that it does not hide, and so on.
    std::size_t left = beside.size();
    while (count < most_hiders) {
        const Beside* nearest = nullptr;
        for (std::size_t n = 0; n < left; ++n) {
            const Beside& one = beside[n];
            if (one.apart && (!nearest || std::abs(one.distance) < std::abs(nearest->distance)))
                nearest = &one;
        }
        if (!nearest) break;
        const Beside occluder = occluders[count++] = *nearest;
        const auto kept = std::remove_if(
            beside.begin(), beside.begin() + static_cast<std::ptrdiff_t>(left), [&](const Beside& one) {
                return one.patch == occluder.patch || (one.apart && is_hidden(one, occluder, half));
            });
        left = static_cast<std::size_t>(kept - beside.begin());
    }
    list.clear();
    for (std::size_t n = 0; n < count; ++n) list.push_back(occluders[n].patch);
    for (std::size_t n = 0; n < left; ++n) list.push_back(beside[n].patch);
    std::sort(list.begin(), list.end());
}

// Adds the patches among some that come within the reach of a place.
void PatchGrid::add_within(Vec3 center, double reach, std::span<const std::uint32_t> from,
                           std::vector<std::uint32_t>& out) const {
    for (const std::uint32_t n : from) {
        if (squared_length(patches_[n].offset_from(center, margin_)) <= reach * reach) out.push_back(n);
    }
}

// Blocks of cells keep the patches near them, their cells choose from these.
void PatchGrid::list_patches(const std::vector<std::uint32_t>& drawn, double cell, int threads) {
    // Cells choose their patches from those near a block of so many cells along each axis. [cells; > 0; B]
    constexpr std::uint32_t block = 4;
    const std::uint32_t nx = cells_[0], ny = cells_[1], nz = cells_[2];
    const double half_diagonal = 0.5 * std::sqrt(3.0) * cell * (1 + 1e-9);
    const std::uint32_t bx = (nx + block - 1) / block, by = (ny + block - 1) / block;
    // A layer of cells a job.
    std::vector<std::vector<std::uint32_t>> counts(nz);
    std::vector<std::vector<Listed>> lists(nz);
    parallel_for(nz, block, threads, [&](std::size_t begin, std::size_t end) {
        std::vector<std::vector<std::uint32_t>> near(std::size_t{bx} * by);
        for (std::size_t b = 0; b < near.size(); ++b) {
            const double x = (static_cast<double>(b % bx) + 0.5) * block,
                         y = (static_cast<double>(b / bx) + 0.5) * block,
                         z = 0.5 * static_cast<double>(begin + end);
            add_within(box_.low + cell * Vec3{x, y, z}, radius_ + block * half_diagonal, drawn, near[b]);
        }
        std::vector<std::uint32_t> here;
        std::vector<Beside> scratch;
        for (std::size_t k = begin; k < end; ++k) {
            for (std::uint32_t j = 0; j < ny; ++j) {
                for (std::uint32_t i = 0; i < nx; ++i) {
                    const Vec3 center =
                        box_.low + cell * Vec3{static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5,
                                               static_cast<double>(k) + 0.5};
                    here.clear();
                    add_within(center, radius_ + half_diagonal,
                               near[(j / block) * std::size_t{bx} + i / block], here);
                    if (here.size() > few_listed) drop_hidden(center, 0.5 * cell * (1 + 1e-9), here, scratch);
                    for (const std::uint32_t n : here) {
                        const bool against =
                            dot(patches_[n].plane.normal, patches_[here[0]].plane.normal) < 0;
                        lists[k].push_back({n, is_before(center, half_diagonal, patches_[n]), against});
                    }
                    counts[k].push_back(static_cast<std::uint32_t>(here.size()));
                }
            }
        }
    });
    cell_begin_.assign(1, 0);
    for (std::uint32_t k = 0; k < nz; ++k) {
        for (const std::uint32_t count : counts[k]) cell_begin_.push_back(cell_begin_.back() + count);
        cell_patches_.insert(cell_patches_.end(), lists[k].begin(), lists[k].end());
    }
}

}  // namespace anatomesh
