#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

namespace {

// Values are counted up to so many: an image with more is no label map. [values; > few; B]
constexpr std::uint32_t most_distinct = 1000;

// Counts different values until there are too many for a label map or one is negative.
class DistinctCounter {
  public:
    void see(float value) {
        if (count_ > most_distinct || value == last_) return;
        last_ = value;
        if (value < 0) {
            count_ = most_distinct + 1;
        } else if (const auto whole = static_cast<std::uint32_t>(std::min(value, 16777216.0F));
                   static_cast<float>(whole) == value && whole < small_.size()) {
            if (!small_[whole]) ++count_;
            small_[whole] = true;
        } else {
            const auto at = std::lower_bound(others_.begin(), others_.end(), value);
            if (at != others_.end() && *at == value) return;
            others_.insert(at, value);
            ++count_;
        }
    }
    std::uint32_t count() const { return count_; }

  private:
    std::vector<bool> small_ = std::vector<bool>(65536);
    std::vector<float> others_;  // sorted, at most most_distinct + 1
    float last_ = std::numeric_limits<float>::quiet_NaN();
    std::uint32_t count_ = 0;
};

template <class T>
T element(const std::byte* at, bool swap) {
    T value;
    std::memcpy(&value, at, sizeof(T));
    return swap ? byte_swapped(value) : value;
}

template <class T>
void convert(const RawImage& raw, std::size_t first, std::span<float> voxels) {
    const bool swap = raw.order != std::endian::native;
    const bool scaled = raw.slope != 1 || raw.intercept != 0;
    const std::size_t step = raw.stride * sizeof(T);
    const std::byte* at = raw.data.data() + first * step;
    for (float& voxel : voxels) {
        const T value = element<T>(at, swap);
        voxel = scaled ? static_cast<float>(static_cast<double>(value) * raw.slope + raw.intercept)
                       : static_cast<float>(value);
        at += step;
    }
}

// The voxels from `first` on.
void convert(const RawImage& raw, std::size_t first, std::span<float> voxels) {
    switch (raw.type) {
        case VoxelType::u8:
            return convert<std::uint8_t>(raw, first, voxels);
        case VoxelType::i8:
            return convert<std::int8_t>(raw, first, voxels);
        case VoxelType::u16:
            return convert<std::uint16_t>(raw, first, voxels);
        case VoxelType::i16:
            return convert<std::int16_t>(raw, first, voxels);
        case VoxelType::u32:
            return convert<std::uint32_t>(raw, first, voxels);
        case VoxelType::i32:
            return convert<std::int32_t>(raw, first, voxels);
        case VoxelType::u64:
            return convert<std::uint64_t>(raw, first, voxels);
        case VoxelType::i64:
            return convert<std::int64_t>(raw, first, voxels);
        case VoxelType::f32:
            return convert<float>(raw, first, voxels);
        case VoxelType::f64:
            return convert<double>(raw, first, voxels);
    }
}

std::array<std::uint32_t, 3> voxel_at(const ImageGeometry& geometry, std::size_t index) {
    const std::size_t row = index / geometry.size[0];
    return {static_cast<std::uint32_t>(index % geometry.size[0]),
            static_cast<std::uint32_t>(row % geometry.size[1]),
            static_cast<std::uint32_t>(row / geometry.size[1])};
}

// Range, and the values that are no number.
void find_range(const GreyImage& image, ImageFacts& facts) {
    // Eight ranges are kept side by side, so that the compiler can use vector registers; NaN fails every
    // comparison. [ranges; 1 to 16; B]
    constexpr std::size_t lanes = 8;
    constexpr float infinity = std::numeric_limits<float>::infinity();
    constexpr float largest = std::numeric_limits<float>::max();
    std::array<float, lanes> lows, highs;
    std::array<std::uint32_t, lanes> finite{};
    lows.fill(infinity);
    highs.fill(-infinity);
    const std::size_t count = image.voxels.size();
    const auto see = [&](float value, std::size_t lane) {
        const bool usable = std::abs(value) <= largest;
        lows[lane] = usable && value < lows[lane] ? value : lows[lane];
        highs[lane] = usable && value > highs[lane] ? value : highs[lane];
        finite[lane] += usable;
    };
    std::uint64_t all_finite = 0;
    for (std::size_t begin = 0; begin < count; begin += std::size_t{1} << 30) {
        const std::size_t end = std::min(count, begin + (std::size_t{1} << 30));
        std::size_t n = begin;
        for (; n + lanes <= end; n += lanes)
            for (std::size_t lane = 0; lane < lanes; ++lane) see(image.voxels[n + lane], lane);
        for (; n < end; ++n) see(image.voxels[n], 0);
        for (std::uint32_t& of_lane : finite) all_finite += std::exchange(of_lane, 0);
    }
    facts.not_finite = count - all_finite;
    if (all_finite > 0) {
        facts.low = *std::min_element(lows.begin(), lows.end());
        facts.high = *std::max_element(highs.begin(), highs.end());
    }
    if (facts.not_finite > 0) {
        const auto first = std::find_if(image.voxels.begin(), image.voxels.end(),
                                        [](float value) { return !std::isfinite(value); });
        facts.first_not_finite =
            voxel_at(image.geometry, static_cast<std::size_t>(first - image.voxels.begin()));
    }
}

void find_label_facts(const GreyImage& image, bool whole_numbers, ImageFacts& facts) {
    DistinctCounter distinct;
    std::uint64_t pairs = 0, equal = 0;
    float largest_fraction = 0;
    const std::uint32_t row = image.geometry.size[0];
    // A grey image is known for one after a few rows.
    for (std::size_t begin = 0; begin < image.voxels.size() && distinct.count() <= most_distinct;
         begin += row) {
        float before = image.voxels[begin];
        for (std::uint32_t i = 0; i < row; ++i) {
            const float value = image.voxels[begin + i];
            if (value != before || i == 0) distinct.see(value);
            if (i > 0 && (value != 0 || before != 0)) {
                ++pairs;
                equal += value == before;
            }
            if (!whole_numbers)
                largest_fraction = std::max(largest_fraction, std::abs(value - std::rint(value)));
            before = value;
        }
    }
    facts.distinct = distinct.count();
    facts.largest_fraction = largest_fraction;
    facts.equal_neighbors = pairs > 0 ? static_cast<double>(equal) / static_cast<double>(pairs) : 1.0;
}

void replace_not_finite(GreyImage& image, const ImageFacts& facts, RunContext& context) {
    for (float& value : image.voxels)
        if (!std::isfinite(value)) value = facts.low;
    const auto& [i, j, k] = facts.first_not_finite;
    context.warn(image_warning(
        "W-IMG-002",
        fmt::format("{} voxels are not finite, the first at ({}, {}, {})", facts.not_finite, i, j, k),
        image.source, "", fmt::format("they were given the lowest value of the image, {}", facts.low)));
}

}  // namespace

Result<LoadedImage> to_grey(const RawImage& raw, const std::string& path, RunContext& context) {
    LoadedImage loaded;
    loaded.image.geometry = raw.geometry;
    loaded.image.source = path;
    loaded.image.voxels.resize(raw.geometry.voxel_count());
    const std::span<float> voxels = loaded.image.voxels;
    parallel_for(
        voxels.size(), std::size_t{1} << 20, context.threads,
        [&](std::size_t begin, std::size_t end) { convert(raw, begin, voxels.subspan(begin, end - begin)); });
    if (context.cancelled()) return cancelled_error();

    ImageFacts& facts = loaded.facts;
    facts.voxel_type = name_of(raw.type);
    facts.slope = raw.slope;
    facts.intercept = raw.intercept;
    find_range(loaded.image, facts);
    if (facts.not_finite > 0) replace_not_finite(loaded.image, facts, context);
    const bool scaled = raw.slope != 1 || raw.intercept != 0;
    find_label_facts(loaded.image, is_integer(raw.type) && !scaled, facts);
    // Scaled labels are no longer the numbers somebody gave them.
    if (scaled && is_integer(raw.type) && facts.distinct <= most_distinct)
        context.warn(image_warning("W-IMG-003",
                                   fmt::format("the image has few different values, which are scaled by {} x "
                                               "+ {}, unlike those of a label map",
                                               raw.slope, raw.intercept),
                                   path, fmt::format("{}", raw.slope), "the scaled values were used"));
    loaded.structures = raw.structures;
    return loaded;
}

bool looks_like_label_map(const ImageFacts& facts) {
    // Values this near to whole numbers are whole: floats and scaling round. [1; 0 to 0.5; D digits of files]
    constexpr double rounding = 1e-3;
    // An image with so few whole values looks like a label map, however they lie.
    // [values; >= 2; M 2026-11, set not recorded]
    constexpr std::uint32_t few = 16;
    // With more values it does if this share of neighbouring voxels is equal: grey values have noise.
    // [1; 0 to 1; M 2026-11, set not recorded]
    constexpr double mostly = 0.5;
    return facts.not_finite == 0 && facts.low >= 0 && facts.largest_fraction <= rounding &&
           facts.distinct <= most_distinct && (facts.distinct <= few || facts.equal_neighbors >= mostly);
}

}  // namespace anatomesh
