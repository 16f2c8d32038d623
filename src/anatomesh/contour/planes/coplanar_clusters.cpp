#include "anatomesh/contour/planes/coplanar_clusters.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "anatomesh/contour/planes/plane_fit.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

double CoplanarCluster::leverage(Vec3 p) const {
    const Vec3 way = p - mean, inside = way - dot(way, normal) * normal;
    const double spread = dot(inside, scatter.times(inside)) / count, square = squared_length(inside);
    return spread > 0 ? square / std::sqrt(spread) : square > 0 ? std::numeric_limits<double>::infinity() : 0;
}

namespace {

// Points may always lie so far off a plane, as a share of the contours' extent. [1; 0 to 0.01; D a choice, measurement not recorded]
constexpr double least_noise = 1e-5;

CoplanarCluster joined(const CoplanarCluster& large, const CoplanarCluster& small) {
    CoplanarCluster both = large;
    both.contours.insert(both.contours.end(), small.contours.begin(), small.contours.end());
    both.area += small.area;
    both.noise = std::max(large.noise, small.noise);
    both.count += small.count;
    const Vec3 way = small.mean - large.mean;
    both.mean += (small.count / both.count) * way;
    both.scatter.add(small.scatter);
    both.scatter.add(std::sqrt(large.count * small.count / both.count) * way);
    both.normal = least_direction(both.scatter);
    return both;
}

class ClusterFinder {
  public:
    ClusterFinder(std::span<const ContourToPlace> contours, double tolerance, double rounding)
        : contours_(contours), tolerance_(tolerance), rounding_(rounding) {
        Box3 box;
        for (const ContourToPlace& contour : contours) {
            for (const Vec3& p : contour.points) box.extend(p);
        }
        floor_ = least_noise * box.diagonal();
    }

    std::vector<CoplanarCluster> run() const {
        std::vector<CoplanarCluster> singles;
        for (std::uint32_t c = 0; c < contours_.size(); ++c) {
            if (contours_[c].plane < 0) singles.push_back(single(c));
        }
        std::stable_sort(singles.begin(), singles.end(),
                         [](const CoplanarCluster& p, const CoplanarCluster& q) { return p.area > q.area; });
        std::vector<CoplanarCluster> clusters;
        for (CoplanarCluster& one : singles) {
            const std::size_t host = one.noise <= tolerance_ ? host_of(one, clusters) : clusters.size();
            if (host < clusters.size()) {
                clusters[host] = joined(clusters[host], one);
            } else {
                clusters.push_back(std::move(one));
            }
        }
        return clusters;
    }

  private:
    CoplanarCluster single(std::uint32_t c) const {
        const std::span<const Vec3> points = contours_[c].points;
        CoplanarCluster one;
        one.contours = {c};
        one.area = vector_area(points);
        one.count = static_cast<double>(points.size());
        one.mean = mean_of(points);
        one.scatter = scatter_of(points);
        one.normal = least_direction(one.scatter);
        one.noise = deviation(one);
        return one;
    }

    double deviation(const CoplanarCluster& cluster) const {
        double largest = 0;
        for (const std::uint32_t c : cluster.contours) {
            for (const Vec3& p : contours_[c].points)
                largest = std::max(largest, std::abs(dot(p - cluster.mean, cluster.normal)));
        }
        return largest;
    }

    // The cluster whose plane fits best; their number if none does.
    std::size_t host_of(const CoplanarCluster& one, const std::vector<CoplanarCluster>& clusters) const {
        // So many radii of a cluster beside it its plane is known less well, and no further. [radii; > 0; D a choice, measurement not recorded]
        constexpr double furthest = 10;
        std::size_t best = clusters.size();
        double least = 1;
        for (std::size_t s = 0; s < clusters.size(); ++s) {
            const CoplanarCluster& cluster = clusters[s];
            if (cluster.noise > tolerance_) continue;
            const double allowed = fitted_share * std::max({one.noise, cluster.noise, rounding_}) + floor_;
            const double reach = 1 + std::min(cluster.leverage(one.mean), furthest);
            const double off = std::abs(dot(one.mean - cluster.mean, cluster.normal)) / (allowed * reach);
            if (off >= least) continue;
            const double worst = std::max(off, deviation(joined(cluster, one)) / allowed);
            if (worst < least) least = worst, best = s;
        }
        return best;
    }

    std::span<const ContourToPlace> contours_;
    double tolerance_, rounding_, floor_ = 0;
};

}  // namespace

std::vector<CoplanarCluster> find_coplanar_clusters(std::span<const ContourToPlace> contours,
                                                    double tolerance, double rounding) {
    return ClusterFinder(contours, tolerance, rounding).run();
}

}  // namespace anatomesh
