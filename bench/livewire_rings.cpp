// livewire_rings: rings led by a livewire through clicks on a picture, as numbers, for livewire_picture.py.
//
// Standard input: "columns rows step_x step_y rings", then for each ring the number of its clicks and their x and y in mm,
// a newline, and the pixels as 4-byte floats. Standard output: for each ring a line of x and y. Exit code 1: no ring.
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include "anatomesh/live/livewire/livewire_path.h"
#include "anatomesh/live/livewire/smooth_line.h"

namespace {

using namespace anatomesh;

struct Task {
    GreyPicture slice;
    std::vector<std::vector<Vec2>> clicks;
};

Task read_task(std::istream& in) {
    Task task;
    std::size_t rings = 0;
    PictureGrid& grid = task.slice.grid;
    in >> grid.size[0] >> grid.size[1] >> grid.step.x >> grid.step.y >> rings;
    for (std::size_t n = 0; in && n < rings; ++n) {
        std::size_t clicks = 0;
        in >> clicks;
        std::vector<Vec2>& ring = task.clicks.emplace_back();
        for (Vec2 p; ring.size() < clicks && in >> p.x >> p.y;) ring.push_back(p);
    }
    in.get();
    for (float value = 0; in.read(reinterpret_cast<char*>(&value), sizeof value);)
        task.slice.pixels.push_back(value);
    return task;
}

Status print_rings(const Task& task) {
    RunContext context;
    ANATOMESH_TRY(const EdgeFeatures features, find_edge_features(task.slice, {}, context));
    ANATOMESH_TRY(const LivewireCosts costs, make_livewire_costs(features, nullptr, {}, context));
    for (const std::vector<Vec2>& clicks : task.clicks) {
        LivewirePath path(costs);
        for (const Vec2 click : clicks) {
            ANATOMESH_CHECK_STATUS(path.add_anchor(click));
        }
        ANATOMESH_TRY(const std::vector<Vec2> ring, path.ring());
        for (const Vec2 p : smooth_line(ring, true, costs.grid.step)) std::printf("%.4f %.4f ", p.x, p.y);
        std::printf("\n");
    }
    return Nothing{};
}

}  // namespace

int main() {
    const Status done = print_rings(read_task(std::cin));
    if (done.ok()) return 0;
    std::fprintf(stderr, "livewire_rings: %s\n", to_line(done.error()).c_str());
    return 1;
}
