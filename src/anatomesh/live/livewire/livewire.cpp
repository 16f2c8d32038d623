#include "anatomesh/live/livewire/livewire.h"

#include <algorithm>
#include <cassert>

#include "anatomesh/base/standard_arithmetic.h"

namespace anatomesh {

namespace {

// Where anchor and pointer are so far apart that the window has too many pixels, it reaches beyond them by this share of
// their distance: it grows seldom as the pointer goes on. [1, of the longer side; > 0; D a choice, measurement not
// recorded]
constexpr double far_margin_share = 0.25;

// The rectangle about two pixels and `margin` pixels around it, as far as the picture goes.
PixelWindow window_about(Pixel a, Pixel b, std::uint32_t margin, const PictureGrid& grid) {
    const auto low = [&](std::uint32_t at) { return at - std::min(at, margin); };
    const auto high = [&](std::uint32_t at, std::uint32_t side) {
        return std::min<std::uint32_t>(side, at + margin + 1);
    };
    return {low(std::min(a.i, b.i)), low(std::min(a.j, b.j)), high(std::max(a.i, b.i), grid.size[0]),
            high(std::max(a.j, b.j), grid.size[1])};
}

// The same with the largest margin that makes no more pixels than the options say.
PixelWindow window_about(Pixel a, Pixel b, const LivewireOptions& options, const PictureGrid& grid) {
    const auto fits = [&](std::uint32_t margin) {
        const PixelWindow window = window_about(a, b, margin, grid);
        return std::size_t{window.right - window.left} * (window.bottom - window.top) <=
               options.window_pixels;
    };
    if (!fits(options.margin)) {
        const PixelWindow box = window_about(a, b, 0, grid);
        const auto share = static_cast<std::uint32_t>(far_margin_share *
                                                      std::max(box.right - box.left, box.bottom - box.top));
        return window_about(a, b, std::max(options.margin, share), grid);
    }
    std::uint32_t low = options.margin, high = most_pixels_of_side;
    if (fits(high)) return window_about(a, b, high, grid);
    while (high - low > 1) {
        const std::uint32_t middle = (low + high) / 2;
        (fits(middle) ? low : high) = middle;
    }
    return window_about(a, b, low, grid);
}

PixelWindow united(const PixelWindow& a, const PixelWindow& b) {
    return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right),
            std::max(a.bottom, b.bottom)};
}

}  // namespace

Livewire::Livewire(const LivewireCosts& costs, const LivewireOptions& options)
    : costs_(&costs), options_(options), paths_(costs) {
    assert(costs.grid.count() > 0 && options.window_pixels >= 1);
    assert(options.margin >= 1 && options.margin <= most_pixels_of_side);
}

Result<NearestPixel> Livewire::set_anchor(Vec2 point) {
    const StandardArithmetic arithmetic;
    ANATOMESH_CHECK_STATUS(check_picture_point(point, "anchor"));
    const NearestPixel nearest = grid().nearest(point);
    anchor_ = nearest.pixel;
    anchored_ = true;
    paths_.start(grid().index(anchor_), window_about(anchor_, anchor_, options_, grid()));
    return nearest;
}

Result<LivewireLine> Livewire::line_to(Vec2 pointer) {
    assert(anchored_);
    const StandardArithmetic arithmetic;
    ANATOMESH_CHECK_STATUS(check_picture_point(pointer, "pointer"));
    const NearestPixel nearest = grid().nearest(pointer);
    // It grows when half of the margin is used up, and so not with every pixel that the pointer moves.
    if (!window().contains(window_about(anchor_, nearest.pixel, options_.margin / 2, grid()))) {
        paths_.grow(united(window(), window_about(anchor_, nearest.pixel, options_, grid())));
    }
    const std::uint32_t end = grid().index(nearest.pixel);
    const std::uint32_t cost = paths_.settle(end);
    LivewireLine line;
    line.cost_mm = cost * costs_->mm_per_unit();
    line.cheapest = cost <= paths_.escape_cost();
    line.inside = nearest.inside;
    for (const std::uint32_t pixel : paths_.path(end)) {
        line.points.push_back(grid().position(grid().pixel(pixel)));
    }
    return line;
}

bool Livewire::settle_ahead(std::uint32_t pixels) {
    assert(anchored_);
    return paths_.settle_next(pixels);
}

}  // namespace anatomesh
