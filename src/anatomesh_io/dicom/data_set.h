// DataSet: the elements of a DICOM file, found by a walk that checks every length, as a flat tree of views
// into the file. Nothing is copied, no element is interpreted before it is asked for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh_io/contour/dicom_layout.h"

namespace anatomesh {

struct DicomElement {
    DicomTag tag;
    std::uint32_t end = 0;  // index after its last descendant; its own index + 1 for what is no sequence
    std::size_t offset = 0, length = 0;  // of the value; length 0 for sequences and items
};

class DataSet;

// An item of a sequence, or the data set itself. A view: valid as long as its DataSet.
class DicomItem {
  public:
    DicomItem(const DataSet& set, std::uint32_t first, std::uint32_t end)
        : set_(&set), first_(first), end_(end) {}

    // The value as it stands in the file, or empty when there is no such element; find() tells them apart.
    std::string_view bytes(DicomTag tag) const;
    const DicomElement* find(DicomTag tag) const;
    // The value without blanks and NULs at its ends.
    std::string_view text(DicomTag tag) const;
    // The items of a sequence; none when there is no such sequence.
    std::vector<DicomItem> items(DicomTag tag) const;
    // The first item of a sequence.
    std::optional<DicomItem> item(DicomTag tag) const;
    // The fragments of compressed pixel data, the offset table first.
    std::vector<std::string_view> fragments(DicomTag tag) const;

    const DataSet& set() const { return *set_; }

  private:
    const DataSet* set_;
    std::uint32_t first_, end_;
};

class DataSet {
  public:
    // `file` must live as long as the result. Errors: those of dicom_layout.h; E-DCM-001 more than
    // `max_elements` elements (limit). `partial`, when not null, gets what was read before an error.
    // Linear in the file; 32 bytes an element.
    static Result<DataSet> parse(std::string_view file, const std::string& name, DataSet* partial = nullptr);

    DicomItem root() const { return {*this, 0, static_cast<std::uint32_t>(elements_.size())}; }
    const DicomLayout& layout() const { return layout_; }
    bool is_big_endian() const { return layout_.encoding == DicomEncoding::explicit_big; }
    const std::string& name() const { return name_; }
    const std::vector<DicomElement>& elements() const { return elements_; }
    std::string_view value(const DicomElement& element) const {
        return content().substr(element.offset, element.length);
    }

  private:
    std::string_view content() const {
        return layout_.inflated.empty() ? file_ : std::string_view(layout_.inflated);
    }

    std::string name_;
    std::string_view file_;
    DicomLayout layout_;
    std::vector<DicomElement> elements_;
};

// Values of elements. "Nothing" when the element is absent or empty; E-DCM-002, naming the tag, when its
// value is not what it must be (no blanks inside, no "NaN", "1,5", "1e400"; whole numbers for whole numbers).
Result<std::optional<std::vector<double>>> decimals(const DicomItem& item, DicomTag tag, std::size_t count);
Result<std::optional<double>> decimal(const DicomItem& item, DicomTag tag);
Result<std::optional<std::int64_t>> whole_number(const DicomItem& item, DicomTag tag);     // IS
Result<std::optional<std::uint32_t>> unsigned_short(const DicomItem& item, DicomTag tag);  // US
Result<std::optional<double>> float_double(const DicomItem& item, DicomTag tag);           // FD, finite
Result<std::optional<std::vector<std::uint32_t>>> unsigned_shorts(const DicomItem& item, DicomTag tag,
                                                                  std::size_t count);
Result<std::optional<std::vector<double>>> float_doubles(const DicomItem& item, DicomTag tag,
                                                         std::size_t count);

// The error of a value that is not what it must be, and of one that is missing (E-DCM-003).
Error bad_value(const DicomItem& item, DicomTag tag, const std::string& what);
Error missing_value(const DicomItem& item, DicomTag tag, const std::string& what);

}  // namespace anatomesh
