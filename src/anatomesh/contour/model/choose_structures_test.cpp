#include "anatomesh/contour/model/choose_structures.h"

#include <gtest/gtest.h>

namespace anatomesh::choose_structures_test {
namespace {

// Three slices; structure s has a triangle at s on every slice but slice s.
ContourSet three() {
    ContourSet set;
    set.structures = {{4, "a", {}}, {5, "b", {}}, {6, "c", {}}};
    for (std::uint32_t k = 0; k < 3; ++k) {
        Slice slice;
        slice.first_contour = static_cast<std::uint32_t>(set.contours.size());
        for (std::uint32_t s = 0; s < 3; ++s) {
            if (s == k) continue;
            set.contours.push_back({s, k, static_cast<std::uint32_t>(set.points.size()), 3});
            for (int n = 0; n < 3; ++n)
                set.points.push_back({10.0 * s + n, static_cast<double>(n * n), static_cast<double>(k)});
        }
        slice.contour_count = static_cast<std::uint32_t>(set.contours.size()) - slice.first_contour;
        set.slices.push_back(slice);
    }
    return set;
}

TEST(ChooseStructures, their_contours_alone_and_every_slice) {
    const ContourSet all = three();
    for (const std::vector<std::uint32_t>& chosen : {std::vector<std::uint32_t>{1}, {2, 0}, {0, 1, 2}, {}}) {
        const ContourSet part = choose_structures(all, chosen);
        ASSERT_EQ(part.slices.size(), 3u);
        ASSERT_EQ(part.structures.size(), chosen.size());
        EXPECT_EQ(part.contours.size(), 2 * chosen.size());
        EXPECT_EQ(part.points.size(), 6 * chosen.size());
        for (std::uint32_t k = 0; k < 3; ++k) {
            std::uint32_t before = 0;
            for (const Contour& contour : part.contours_of(part.slices[k])) {
                EXPECT_EQ(contour.slice, k);
                EXPECT_GE(contour.structure, before);
                before = contour.structure;
                EXPECT_EQ(part.structures[contour.structure].number,
                          all.structures[chosen[contour.structure]].number);
                EXPECT_EQ(part.points_of(contour)[0],
                          (Vec3{10.0 * chosen[contour.structure], 0, static_cast<double>(k)}));
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::choose_structures_test
