// FrameGroups: the functional groups of a frame: its own, those that all frames share, and the object itself.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh_io/dicom/data_set.h"

namespace anatomesh {

class FrameGroups {
  public:
    FrameGroups(const DicomItem& root, std::optional<DicomItem> shared, std::optional<DicomItem> own)
        : root_(root), shared_(std::move(shared)), own_(std::move(own)) {}

    // The item of the sequence `group` that holds the element: the frame's own, or the one that all frames share;
    // nothing when neither does.
    std::optional<DicomItem> own(DicomTag group, DicomTag tag) const { return item_of(own_, group, tag); }
    std::optional<DicomItem> shared(DicomTag group, DicomTag tag) const {
        return item_of(shared_, group, tag);
    }
    // The item that holds the element: in the sequence `group` of the frame, of the shared ones, or in the
    // object.
    DicomItem holder(DicomTag group, DicomTag tag) const {
        if (const auto item = own(group, tag)) return *item;
        if (const auto item = shared(group, tag)) return *item;
        return root_;
    }

  private:
    static std::optional<DicomItem> item_of(const std::optional<DicomItem>& groups, DicomTag group,
                                            DicomTag tag) {
        const auto item = groups ? groups->item(group) : std::nullopt;
        return item && item->find(tag) ? item : std::nullopt;
    }

    DicomItem root_;
    std::optional<DicomItem> shared_, own_;
};

// An error at a frame, counted from 0, of so many; of one frame alone the place is the file.
Error frame_error(const char* code, const DataSet& set, std::uint32_t frame, std::uint32_t frames,
                  const std::string& message, std::string value, const std::string& next_step);

// Numbers as messages show them, with blanks between.
std::string vector_text(const std::vector<double>& values);

}  // namespace anatomesh
