#include "anatomesh/element/material.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "anatomesh/base/number_text.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

double table_value(const std::vector<std::array<double, 2>>& table, double grey) {
    if (grey <= table.front()[0]) return table.front()[1];
    if (grey >= table.back()[0]) return table.back()[1];
    const auto above = std::upper_bound(table.begin(), table.end(), grey,
                                        [](double value, const auto& row) { return value < row[0]; });
    const auto& [g0, e0] = *(above - 1);
    const auto& [g1, e1] = *above;
    return e0 + (e1 - e0) * (grey - g0) / (g1 - g0);
}

double raw_density(const MaterialLaw& law, double grey) {
    return std::max(0.0, law.intercept + law.slope * grey);
}

// Densities are given in g/cm3 and needed in tonnes per mm3, which go with mm, s and MPa. [t/mm^3; 1e-9; D]
constexpr double tonnes_per_mm3 = 1e-9;

// A mean by volume that is exact where all values are equal.
class Mean {
  public:
    void take(double value, double weight) {
        low_ = weight_ > 0 ? std::min(low_, value) : value;
        high_ = weight_ > 0 ? std::max(high_, value) : value;
        weight_ += weight;
        sum_ += weight * value;
    }
    bool empty() const { return !(weight_ > 0); }
    double value() const { return std::clamp(sum_ / weight_, low_, high_); }

  private:
    double low_ = 0, high_ = 0, weight_ = 0, sum_ = 0;
};

struct Bin {
    Mean young, density;
    std::uint32_t material = 0;
};

}  // namespace

double young_modulus(const MaterialLaw& law, double grey) {
    double young = law.young_mpa;
    if (law.kind == MaterialLaw::Kind::table) young = table_value(law.table, grey);
    if (law.kind == MaterialLaw::Kind::power) {
        young = law.offset_mpa + law.factor_mpa * std::pow(raw_density(law, grey), law.exponent);
    }
    return std::clamp(young, law.low_mpa, law.high_mpa);
}

double density(const MaterialLaw& law, double grey) {
    return law.kind == MaterialLaw::Kind::power ? raw_density(law, grey) : law.density_g_cm3;
}

Result<BinnedMaterials> bin_materials(const TetMesh& mesh, std::span<const double> grey,
                                      std::span<const MaterialLaw> laws,
                                      std::span<const std::uint32_t> law_of_region) {
    assert(grey.empty() || grey.size() == mesh.cells.size());
    const auto grey_of = [&](std::size_t c) { return grey.empty() ? 0.0 : grey[c]; };
    std::vector<double> young(mesh.cells.size());
    std::vector<std::array<double, 2>> range(laws.size(), {std::numeric_limits<double>::infinity(), 0});
    for (std::size_t c = 0; c < young.size(); ++c) {
        const std::uint32_t law = law_of_region[mesh.regions[c]];
        young[c] = young_modulus(laws[law], grey_of(c));
        if (!(young[c] > 0) || !std::isfinite(young[c])) {
            Error error{ErrorKind::input,
                        "E-ELM-002",
                        "the law gives a Young's modulus of " + brief(young[c]) + " MPa at grey value " +
                            brief(grey_of(c)),
                        {},
                        "set low_mpa above 0 in the law, or change it"};
            return error;
        }
        range[law] = {std::min(range[law][0], young[c]), std::max(range[law][1], young[c])};
    }
    const auto bin_of = [&](std::size_t c) {
        const std::uint32_t law = law_of_region[mesh.regions[c]];
        const auto [low, high] = range[law];
        if (!(high > low)) return std::size_t{0};
        const auto bin = static_cast<std::size_t>((young[c] - low) / (high - low) * laws[law].bins);
        return std::min<std::size_t>(bin, laws[law].bins - 1);
    };
    std::vector<std::vector<Bin>> bins(laws.size());
    for (std::size_t l = 0; l < laws.size(); ++l) bins[l].resize(laws[l].bins);
    for (std::size_t c = 0; c < young.size(); ++c) {
        const std::uint32_t law = law_of_region[mesh.regions[c]];
        const auto& [p, q, r, s] = mesh.cells[c];
        const double volume = signed_volume(mesh.points[p], mesh.points[q], mesh.points[r], mesh.points[s]);
        Bin& bin = bins[law][bin_of(c)];
        bin.young.take(young[c], volume);
        bin.density.take(density(laws[law], grey_of(c)), volume);
    }
    BinnedMaterials result;
    for (std::size_t l = 0; l < laws.size(); ++l) {
        for (Bin& bin : bins[l]) {
            if (bin.young.empty()) continue;
            bin.material = static_cast<std::uint32_t>(result.materials.size());
            result.materials.push_back(
                {bin.young.value(), laws[l].poisson, tonnes_per_mm3 * bin.density.value()});
        }
    }
    result.of_cell.reserve(young.size());
    for (std::size_t c = 0; c < young.size(); ++c) {
        result.of_cell.push_back(bins[law_of_region[mesh.regions[c]]][bin_of(c)].material);
    }
    return result;
}

}  // namespace anatomesh
