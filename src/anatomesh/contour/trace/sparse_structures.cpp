#include "anatomesh/contour/trace/sparse_structures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace anatomesh {

namespace {

// A structure on fewer slices has no spacing of its own. [slices; >= 2; D]
constexpr std::size_t least_slices = 3;
// Slices that follow each other show one body if they overlap by this part of the smaller one.
// [1; 0 to 1; D more than half cannot be by chance for two bodies side by side]
constexpr double least_overlap = 0.5;
// So many of the pairs of slices must show one body. [1; 0 to 1; D a majority]
constexpr double least_overlapping = 0.5;
// So many of the slices must stand alone. [1; 0 to 1; D a majority of two thirds]
constexpr double least_alone = 0.6;

// On which slices along each axis a structure is.
using Occupied = std::array<std::vector<bool>, 3>;

std::vector<Occupied> occupied_slices(const LabelMap& labels) {
    const auto& size = labels.geometry.size;
    std::vector<Occupied> occupied(labels.structures.size());
    for (Occupied& of : occupied)
        for (std::size_t axis = 0; axis < 3; ++axis) of[axis].resize(size[axis]);
    std::size_t voxel = 0;
    for (std::uint32_t k = 0; k < size[2]; ++k) {
        for (std::uint32_t j = 0; j < size[1]; ++j) {
            for (std::uint32_t i = 0; i < size[0]; ++i, ++voxel) {
                const std::uint16_t label = labels.voxels[voxel];
                if (label == 0) continue;
                Occupied& of = occupied[label - 1u];
                of[0][i] = of[1][j] = of[2][k] = true;
            }
        }
    }
    return occupied;
}

// The slices of a structure along an axis, if there are enough and nearly all stand alone: a stray voxel, or one
// slice painted beside another, changes nothing about the others.
std::optional<std::vector<std::uint32_t>> lone_slices(const std::vector<bool>& occupied) {
    std::vector<std::uint32_t> slices;
    std::size_t alone = 0;
    for (std::uint32_t n = 0; n < occupied.size(); ++n) {
        if (!occupied[n]) continue;
        slices.push_back(n);
        alone += !(n > 0 && occupied[n - 1]) && !(n + 1 < occupied.size() && occupied[n + 1]);
    }
    if (alone < least_slices || static_cast<double>(alone) < least_alone * static_cast<double>(slices.size()))
        return std::nullopt;
    return slices;
}

struct Candidate {
    std::uint32_t structure = 0, axis = 0;
    std::vector<std::uint32_t> slices;
    std::vector<std::uint64_t> pixels = {};   // of each slice
    std::vector<std::uint64_t> overlap = {};  // of each slice with the next one

    std::uint32_t place_of(std::uint32_t slice) const {
        return static_cast<std::uint32_t>(std::lower_bound(slices.begin(), slices.end(), slice) -
                                          slices.begin());
    }
};

void count_overlaps(const LabelMap& labels, std::vector<std::optional<Candidate>>& candidates) {
    const auto& size = labels.geometry.size;
    const std::array<std::size_t, 3> stride{1, size[0], std::size_t{size[0]} * size[1]};
    std::size_t voxel = 0;
    for (std::uint32_t k = 0; k < size[2]; ++k) {
        for (std::uint32_t j = 0; j < size[1]; ++j) {
            for (std::uint32_t i = 0; i < size[0]; ++i, ++voxel) {
                const std::uint16_t label = labels.voxels[voxel];
                if (label == 0 || !candidates[label - 1u]) continue;
                Candidate& of = *candidates[label - 1u];
                const std::uint32_t place = of.place_of(std::array{i, j, k}[of.axis]);
                ++of.pixels[place];
                if (place + 1 == of.slices.size()) continue;
                const std::size_t next = voxel + (of.slices[place + 1] - of.slices[place]) * stride[of.axis];
                of.overlap[place] += labels.voxels[next] == label;
            }
        }
    }
}

bool shows_one_body(const Candidate& of) {
    std::size_t overlapping = 0;
    for (std::size_t n = 0; n + 1 < of.slices.size(); ++n) {
        const auto smaller = static_cast<double>(std::min(of.pixels[n], of.pixels[n + 1]));
        overlapping += static_cast<double>(of.overlap[n]) >= least_overlap * smaller;
    }
    return static_cast<double>(overlapping) >= least_overlapping * static_cast<double>(of.slices.size() - 1);
}

SparseStructure sparse_of(const Candidate& of, double voxel_mm3) {
    SparseStructure sparse{of.structure, of.axis, static_cast<std::uint32_t>(of.slices.size())};
    std::vector<std::uint32_t> steps;
    double joined = 0;
    for (std::size_t n = 0; n < of.slices.size(); ++n) {
        sparse.painted_mm3 += static_cast<double>(of.pixels[n]) * voxel_mm3;
        if (n + 1 == of.slices.size()) continue;
        steps.push_back(of.slices[n + 1] - of.slices[n]);
        joined += 0.5 * static_cast<double>(of.pixels[n] + of.pixels[n + 1]) * steps.back();
    }
    // Half a step beyond both ends, as a model ends.
    joined += 0.5 * (static_cast<double>(of.pixels.front()) * steps.front() +
                     static_cast<double>(of.pixels.back()) * steps.back());
    sparse.joined_mm3 = joined * voxel_mm3;
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                     steps.end());
    sparse.step = steps[steps.size() / 2];
    return sparse;
}

}  // namespace

std::vector<SparseStructure> find_sparse_structures(const LabelMap& labels) {
    const std::vector<Occupied> occupied = occupied_slices(labels);
    std::vector<std::optional<Candidate>> candidates(labels.structures.size());
    for (std::uint32_t s = 0; s < candidates.size(); ++s) {
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            auto slices = lone_slices(occupied[s][axis]);
            if (!slices || (candidates[s] && candidates[s]->slices.size() <= slices->size())) continue;
            Candidate found{s, axis, std::move(*slices)};
            found.pixels.resize(found.slices.size());
            found.overlap.resize(found.slices.size());
            candidates[s] = std::move(found);
        }
    }
    std::vector<SparseStructure> sparse;
    if (std::none_of(candidates.begin(), candidates.end(), [](const auto& of) { return of.has_value(); }))
        return sparse;
    count_overlaps(labels, candidates);
    const auto& step = labels.geometry.step;
    const double voxel_mm3 = std::abs(dot(cross(step[0], step[1]), step[2]));
    for (const std::optional<Candidate>& of : candidates)
        if (of && shows_one_body(*of)) sparse.push_back(sparse_of(*of, voxel_mm3));
    return sparse;
}

}  // namespace anatomesh
