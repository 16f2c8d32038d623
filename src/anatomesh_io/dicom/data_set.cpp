#include "anatomesh_io/dicom/data_set.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "anatomesh_io/contour/dicom_text.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/contour/raw_builder.h"
#include "anatomesh_io/dicom/tags.h"

namespace anatomesh {

namespace {

// A file with more elements is refused, before they take all memory. [elements; >= 1000; B]
constexpr std::size_t max_elements = 50'000'000;
constexpr DicomTag item_tag{0xFFFE, 0xE000};

// The sequences that this room looks into: where a file does not say what is one, the others are passed over.
constexpr std::array known_sequences{tags::referenced_series_sequence,
                                     tags::source_image_sequence,
                                     tags::derivation_image_sequence,
                                     tags::referenced_instance_sequence,
                                     tags::ultrasound_regions,
                                     tags::frame_content_sequence,
                                     tags::plane_position_sequence,
                                     tags::plane_orientation_sequence,
                                     tags::plane_position_volume_sequence,
                                     tags::plane_orientation_volume_sequence,
                                     tags::detector_information_sequence,
                                     tags::pixel_measures_sequence,
                                     tags::pixel_transformation_sequence,
                                     tags::segment_sequence,
                                     tags::segment_identification_sequence,
                                     tags::referenced_frame_sequence,
                                     tags::rt_referenced_study_sequence,
                                     tags::rt_referenced_series_sequence,
                                     tags::contour_image_sequence,
                                     tags::structure_set_roi_sequence,
                                     tags::roi_contour_sequence,
                                     tags::contour_sequence,
                                     tags::shared_groups,
                                     tags::per_frame_groups};

bool is_known_sequence(std::uint16_t group, std::uint16_t element) {
    return std::find(known_sequences.begin(), known_sequences.end(), DicomTag{group, element}) !=
           known_sequences.end();
}

// Builds the flat tree; what comes after the limit is counted, not kept.
class Collector : public DicomEvents {
  public:
    explicit Collector(std::vector<DicomElement>& elements) : elements_(elements) {}

    void element(DicomTag tag, std::string_view, std::size_t offset, std::size_t length) override {
        if (!take()) return;
        elements_.push_back({tag, static_cast<std::uint32_t>(elements_.size() + 1), offset, length});
    }
    void begin(DicomTag tag, std::size_t offset) override {
        open_.push_back(static_cast<std::uint32_t>(elements_.size()));
        if (take()) elements_.push_back({tag, 0, offset, 0});
    }
    void end() override {
        const std::uint32_t index = open_.back();
        open_.pop_back();
        if (index < elements_.size()) elements_[index].end = static_cast<std::uint32_t>(elements_.size());
    }
    // After an error, closes what is still open.
    void finish() {
        while (!open_.empty()) end();
    }
    bool is_full() const { return is_full_; }

  private:
    bool take() {
        is_full_ = is_full_ || elements_.size() >= max_elements;
        return !is_full_;
    }

    std::vector<DicomElement>& elements_;
    std::vector<std::uint32_t> open_;
    bool is_full_ = false;
};

Error value_error(const char* code, const DicomItem& item, DicomTag tag, const std::string& what) {
    bool changed = false;
    return {ErrorKind::input,
            code,
            text_of(tag) + " " + what,
            {item.set().name(), {}, {}, {}, valid_utf8(shown(item.text(tag)), changed)},
            "correct the file, or export it again"};
}

// The bits of a number in the byte order of the file.
std::uint64_t bits_at(const DicomItem& item, std::string_view bytes) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
        bits = bits << 8 |
               static_cast<unsigned char>(bytes[item.set().is_big_endian() ? i : bytes.size() - 1 - i]);
    return bits;
}

}  // namespace

const DicomElement* DicomItem::find(DicomTag tag) const {
    const auto& elements = set_->elements();
    for (std::uint32_t i = first_; i < end_; i = elements[i].end)
        if (elements[i].tag == tag) return &elements[i];
    return nullptr;
}

std::string_view DicomItem::bytes(DicomTag tag) const {
    const DicomElement* element = find(tag);
    return element ? set_->value(*element) : std::string_view{};
}

std::string_view DicomItem::text(DicomTag tag) const {
    return without_padding(bytes(tag));
}

std::vector<DicomItem> DicomItem::items(DicomTag tag) const {
    std::vector<DicomItem> found;
    const DicomElement* element = find(tag);
    if (!element) return found;
    const auto& elements = set_->elements();
    const auto first = static_cast<std::uint32_t>(element - elements.data()) + 1;
    for (std::uint32_t i = first; i < element->end; i = elements[i].end)
        if (elements[i].tag == item_tag) found.emplace_back(*set_, i + 1, elements[i].end);
    return found;
}

std::optional<DicomItem> DicomItem::item(DicomTag tag) const {
    const DicomElement* element = find(tag);
    if (!element) return std::nullopt;
    const auto& elements = set_->elements();
    const auto first = static_cast<std::uint32_t>(element - elements.data()) + 1;
    if (first >= element->end) return std::nullopt;
    return DicomItem(*set_, first + 1, elements[first].end);
}

std::vector<std::string_view> DicomItem::fragments(DicomTag tag) const {
    std::vector<std::string_view> found;
    const DicomElement* element = find(tag);
    if (!element) return found;
    const auto& elements = set_->elements();
    const auto first = static_cast<std::uint32_t>(element - elements.data()) + 1;
    for (std::uint32_t i = first; i < element->end; i = elements[i].end)
        found.push_back(set_->value(elements[i]));
    return found;
}

Result<DataSet> DataSet::parse(std::string_view file, const std::string& name, DataSet* partial) {
    DataSet set;
    set.name_ = name;
    set.file_ = file;
    Collector collector(set.elements_);
    auto layout = check_dicom_layout(file, name, is_known_sequence, {}, &collector);
    if (layout.ok() && !collector.is_full()) {
        set.layout_ = std::move(layout).value();
        return set;
    }
    collector.finish();
    // Offsets of a deflated data set are not those of the file.
    if (!set.elements_.empty() && set.elements_.back().offset + set.elements_.back().length > file.size())
        set.elements_.clear();
    Error error = layout.ok() ? Error{ErrorKind::limit,
                                      "E-DCM-001",
                                      "the file has more than " + std::to_string(max_elements) + " elements",
                                      {name, {}, {}, {}, {}},
                                      "do not use this file: it is damaged or malicious"}
                              : std::move(layout).error();
    if (partial) *partial = std::move(set);
    return error;
}

Error bad_value(const DicomItem& item, DicomTag tag, const std::string& what) {
    return value_error("E-DCM-002", item, tag, what);
}

Error missing_value(const DicomItem& item, DicomTag tag, const std::string& what) {
    return value_error("E-DCM-003", item, tag, what);
}

Result<std::optional<std::vector<double>>> decimals(const DicomItem& item, DicomTag tag, std::size_t count) {
    std::string_view rest = item.text(tag);
    if (rest.empty()) return std::optional<std::vector<double>>{};
    std::vector<double> values;
    while (values.size() <= count) {
        const std::size_t end = std::min(rest.find('\\'), rest.size());
        const auto value = parse_number(without_padding(rest.substr(0, end)));
        if (!value) return bad_value(item, tag, "holds a value that is no number");
        values.push_back(*value);
        if (end == rest.size()) break;
        rest.remove_prefix(end + 1);
    }
    if (values.size() != count)
        return bad_value(item, tag, "does not hold " + std::to_string(count) + " numbers");
    return std::optional(std::move(values));
}

Result<std::optional<double>> decimal(const DicomItem& item, DicomTag tag) {
    ANATOMESH_TRY(const auto values, decimals(item, tag, 1));
    return values ? std::optional((*values)[0]) : std::nullopt;
}

Result<std::optional<std::int64_t>> whole_number(const DicomItem& item, DicomTag tag) {
    const std::string_view text = item.text(tag);
    if (text.empty()) return std::optional<std::int64_t>{};
    const auto value = parse_integer<std::int64_t>(text);
    if (!value) return bad_value(item, tag, "is no whole number");
    return value;
}

Result<std::optional<std::vector<std::uint32_t>>> unsigned_shorts(const DicomItem& item, DicomTag tag,
                                                                  std::size_t count) {
    constexpr std::size_t size = sizeof(std::uint16_t);
    const std::string_view bytes = item.bytes(tag);
    if (bytes.empty()) return std::optional<std::vector<std::uint32_t>>{};
    if (bytes.size() != size * count)
        return bad_value(item, tag,
                         count == 1 ? "is no unsigned number of 16 bits"
                                    : "does not hold " + std::to_string(count) + " numbers of 16 bits");
    std::vector<std::uint32_t> values;
    for (std::size_t n = 0; n < count; ++n)
        values.push_back(static_cast<std::uint32_t>(bits_at(item, bytes.substr(size * n, size))));
    return std::optional(std::move(values));
}

Result<std::optional<std::uint32_t>> unsigned_short(const DicomItem& item, DicomTag tag) {
    ANATOMESH_TRY(const auto values, unsigned_shorts(item, tag, 1));
    return values ? std::optional(values->front()) : std::nullopt;
}

Result<std::optional<std::vector<double>>> float_doubles(const DicomItem& item, DicomTag tag,
                                                         std::size_t count) {
    constexpr std::size_t size = sizeof(double);
    const std::string_view bytes = item.bytes(tag);
    if (bytes.empty()) return std::optional<std::vector<double>>{};
    if (bytes.size() != size * count)
        return bad_value(item, tag,
                         count == 1 ? "is no number of 64 bits"
                                    : "does not hold " + std::to_string(count) + " numbers of 64 bits");
    std::vector<double> values;
    for (std::size_t n = 0; n < count; ++n) {
        values.push_back(std::bit_cast<double>(bits_at(item, bytes.substr(size * n, size))));
        if (!std::isfinite(values.back())) return bad_value(item, tag, "is not finite");
    }
    return std::optional(std::move(values));
}

Result<std::optional<double>> float_double(const DicomItem& item, DicomTag tag) {
    ANATOMESH_TRY(const auto values, float_doubles(item, tag, 1));
    return values ? std::optional(values->front()) : std::nullopt;
}

}  // namespace anatomesh
