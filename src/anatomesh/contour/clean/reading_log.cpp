#include "anatomesh/contour/clean/reading_log.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <iterator>
#include <utility>

namespace anatomesh {

std::string structure_text(const Structure& structure) {
    return structure.name.empty() ? std::to_string(structure.number) : structure.name;
}

Place place_of_contour(const RawContours& raw, std::uint32_t contour) {
    const RawContour& entry = raw.contours[contour];
    Place place;
    place.file = raw.source;
    place.structure = structure_text(raw.structures[entry.structure]);
    place.contour = entry.name.empty() ? std::to_string(contour) : entry.name;
    return place;
}

ReadingLog::ReadingLog(const RawContours& raw) : raw_(raw), is_repaired_(raw.contours.size(), 0) {
    for (std::size_t c = 0; c < raw.contours.size(); ++c) {
        const RawContour& contour = raw.contours[c];
        assert(contour.structure < raw.structures.size());
        assert(contour.plane < static_cast<std::int64_t>(raw.planes.size()));
        assert(std::size_t{contour.first_point} + contour.point_count <= raw.points.size());
        ContourLog entry;
        entry.raw_contour = static_cast<std::uint32_t>(c);
        entry.points_in = contour.point_count;
        entries_.push_back(entry);
    }
}

void ReadingLog::note(std::uint32_t contour, std::string code, std::string message, std::string value,
                      std::string what_was_done) {
    Place place = place_of_contour(raw_, contour);
    place.value = std::move(value);
    notes_.push_back(
        {contour, {std::move(code), std::move(message), std::move(place), std::move(what_was_done)}});
}

void ReadingLog::append(std::vector<RingNote> notes) {
    notes_.insert(notes_.end(), std::make_move_iterator(notes.begin()), std::make_move_iterator(notes.end()));
}

void ReadingLog::add_rule(std::uint32_t contour, const std::string& rule) {
    std::string& text_so_far = of(contour).rule;
    text_so_far += text_so_far.empty() ? rule : "; " + rule;
}

void ReadingLog::warn(RunContext& context) {
    std::stable_sort(notes_.begin(), notes_.end(),
                     [](const RingNote& p, const RingNote& q) { return p.source < q.source; });
    for (RingNote& note : notes_) context.warn(std::move(note.warning));
    notes_.clear();
}

CleanStats ReadingLog::stats() const {
    CleanStats stats;
    stats.contours_in = static_cast<std::uint32_t>(entries_.size());
    for (const std::uint8_t is_repaired : is_repaired_) stats.repaired += is_repaired;
    for (const ContourLog& entry : entries_) {
        stats.points_in += entry.points_in;
        stats.dropped += entry.points_kept == 0;
        stats.max_displacement_mm = std::max(stats.max_displacement_mm, entry.max_displacement_mm);
    }
    return stats;
}

}  // namespace anatomesh
