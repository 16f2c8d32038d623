#include "anatomesh/contour/overlay/slice_soundness.h"

#include <algorithm>
#include <numeric>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// Whether two segments of a slice may meet as they do.
bool may_meet(const Segment2& s, const Segment2& t, bool neighbours, bool same_structure) {
    switch (segment_contact(s.a, s.b, t.a, t.b)) {
        case SegmentContact::none:
            return true;
        case SegmentContact::touch: {
            const bool at_ends = s.a == t.a || s.a == t.b || s.b == t.a || s.b == t.b;
            return at_ends && (neighbours || !same_structure);
        }
        case SegmentContact::overlap:
            return !same_structure && ((s.a == t.a && s.b == t.b) || (s.a == t.b && s.b == t.a));
        default:
            return false;
    }
}

class FaultFinder {
  public:
    explicit FaultFinder(std::span<const PlaneRing> rings) : rings_(rings) {}

    std::vector<RingSegment> run(bool exclusive) {
        std::vector<std::uint32_t> order(rings_.size());
        std::iota(order.begin(), order.end(), 0u);
        std::stable_sort(order.begin(), order.end(), [&](std::uint32_t p, std::uint32_t q) {
            return rings_[p].structure < rings_[q].structure;
        });
        if (exclusive) check_contacts(order, true);
        for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
            while (end < order.size() && rings_[order[end]].structure == rings_[order[begin]].structure) {
                ++end;
            }
            check_structure({order.data() + begin, end - begin});
        }
        return std::move(faults_);
    }

  private:
    // Gathers the segments of some rings; segments of no length are faults.
    void gather(std::span<const std::uint32_t> rings) {
        segments_.clear();
        owners_.clear();
        for (const std::uint32_t r : rings) {
            const std::vector<Vec2>& at = rings_[r].at;
            for (std::uint32_t i = 0; i < at.size(); ++i) {
                const Vec2 next = at[i + 1 == at.size() ? 0 : i + 1];
                if (at[i] == next) {
                    faults_.push_back({r, i});
                    continue;
                }
                segments_.push_back({at[i], next});
                owners_.push_back({r, i});
            }
        }
    }

    bool neighbours(RingSegment p, RingSegment q) const {
        if (p.ring != q.ring) return false;
        const auto count = static_cast<std::uint32_t>(rings_[p.ring].at.size());
        return (p.place + 1) % count == q.place || (q.place + 1) % count == p.place;
    }

    // Looks for contacts of the gathered segments, of different structures or of one.
    SegmentIndex check_contacts(std::span<const std::uint32_t> rings, bool between_structures) {
        gather(rings);
        SegmentIndex index(segments_);
        index.for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            const RingSegment p = owners_[i], q = owners_[j];
            const bool same = rings_[p.ring].structure == rings_[q.ring].structure;
            if (same == between_structures) return true;
            if (!may_meet(segments_[i], segments_[j], neighbours(p, q), same)) {
                faults_.push_back(p);
                faults_.push_back(q);
            }
            return true;
        });
        return index;
    }

    void check_structure(std::span<const std::uint32_t> rings) {
        const std::size_t before = faults_.size();
        const SegmentIndex index = check_contacts(rings, false);
        if (faults_.size() > before) return;
        std::vector<std::uint32_t> below;
        for (const std::uint32_t r : rings) {
            below.clear();
            index.below(rings_[r].at.front(), below);
            const auto others = std::count_if(below.begin(), below.end(), [&](std::uint32_t segment) {
                return owners_[segment].ring != r;
            });
            if ((signed_area(rings_[r].at) > 0) != (others % 2 == 0)) faults_.push_back({r, 0});
        }
    }

    std::span<const PlaneRing> rings_;
    std::vector<Segment2> segments_;
    std::vector<RingSegment> owners_;
    std::vector<RingSegment> faults_;
};

}  // namespace

std::vector<PlaneRing> plane_rings(const ContourSet& set, const Slice& slice) {
    std::vector<PlaneRing> rings;
    for (const Contour& contour : set.contours_of(slice)) {
        PlaneRing& ring = rings.emplace_back(PlaneRing{contour.structure, {}});
        for (const Vec3 p : set.points_of(contour)) ring.at.push_back(slice.plane.to_plane(p));
    }
    return rings;
}

std::vector<RingSegment> slice_faults(std::span<const PlaneRing> rings, bool exclusive) {
    return FaultFinder(rings).run(exclusive);
}

}  // namespace anatomesh
