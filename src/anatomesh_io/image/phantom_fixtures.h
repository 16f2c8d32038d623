// One phantom, written in every format, for tests of positions.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "anatomesh_io/image/image_fixtures.h"

namespace anatomesh::fixtures {

inline std::string text_of(Vec3 v, const char* separator) {
    char text[128];
    std::snprintf(text, sizeof text, "%.17g%s%.17g%s%.17g", v.x, separator, v.y, separator, v.z);
    return text;
}

// The phantom: 3 x 4 x 5 voxels, no axis like another, every voxel its own value. Its place in LPS:
struct Phantom {
    Vec3 origin;
    std::array<Vec3, 3> step;
    std::string data() const {
        std::vector<std::int16_t> values;
        for (int n = 0; n < 60; ++n) values.push_back(static_cast<std::int16_t>(n * n % 61 + n));
        return values_as_bytes(values);
    }
    static Vec3 turned(Vec3 v) { return {-v.x, -v.y, v.z}; }

    std::string nifti(int version) const {
        Nifti file;
        file.version = version;
        const Vec3 o = turned(origin), a = turned(step[0]), b = turned(step[1]), c = turned(step[2]);
        file.pixdim = {1, length(a), length(b), length(c), 0, 0, 0, 0};
        file.srow = {a.x, b.x, c.x, o.x, a.y, b.y, c.y, o.y, a.z, b.z, c.z, o.z};
        file.data = data();
        return file.bytes();
    }
    std::string nrrd(bool ras) const {
        const auto in_space = [&](Vec3 v) { return "(" + text_of(ras ? turned(v) : v, ",") + ")"; };
        return "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 5\nendian: little\nencoding: raw\nspace: " +
               std::string(ras ? "right-anterior-superior" : "left-posterior-superior") +
               "\nspace directions: " + in_space(step[0]) + " " + in_space(step[1]) + " " +
               in_space(step[2]) + "\nspace origin: " + in_space(origin) + "\n\n" + data();
    }
    std::string metaimage() const {
        std::string matrix, spacing;
        for (const Vec3 s : step) {
            matrix += text_of((1 / length(s)) * s, " ") + " ";
            spacing += std::to_string(length(s)) + " ";
        }
        return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = "
               "False\nTransformMatrix = " +
               matrix + "\nOffset = " + text_of(origin, " ") + "\nElementSpacing = " + spacing +
               "\nAnatomicalOrientation = RAI\nDimSize = 3 4 5\nElementType = MET_SHORT\nElementDataFile = "
               "LOCAL\n" +
               data();
    }
};

// Axes along the frame's in another order and direction; every number exact in 32 bits.
inline Phantom axis_phantom() {
    return {{-12.5, 40.25, -7}, {Vec3{0, 0, -0.75}, Vec3{0.5, 0, 0}, Vec3{0, -2, 0}}};
}

// Turned about two axes.
inline Phantom oblique_phantom() {
    const double c = std::cos(0.3), s = std::sin(0.3), d = std::cos(-1.1), e = std::sin(-1.1);
    return {{-12.5, 40.25, -7},
            {0.75 * Vec3{c, s * d, s * e}, 0.5 * Vec3{-s, c * d, c * e}, 2 * Vec3{0, -e, d}}};
}

}  // namespace anatomesh::fixtures
