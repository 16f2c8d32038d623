// Relations: how any two structures of a set lie to each other, over all slices.
#pragma once

#include <cstddef>
#include <vector>

namespace anatomesh {

// A structure that has less than this in common with another one has nothing, on a slice or over all. [mm^2;
// > 0; D]
inline constexpr double least_overlap_mm2 = 1e-6;

// What one structure has to do with another one, over all slices that draw both.
struct Relation {
    double common = 0;     // area that both have, mm^2
    double shared = 0;     // length of outlines that both have, mm
    double area = 0;       // of the first one, mm^2
    double perimeter = 0;  // of the first one, mm
    bool alone = false;    // a slice between the first one's own draws the second one alone
    bool between = false;  // no slice draws both: of one's contours and those of the other's next slices
};

// A matrix of relations; that of a structure to itself has its area and perimeter over all of its slices.
class Relations {
  public:
    explicit Relations(std::size_t count) : count_(count), all_(count * count) {}

    std::size_t count() const { return count_; }
    Relation& of(std::size_t s, std::size_t t) { return all_[s * count_ + t]; }
    const Relation& of(std::size_t s, std::size_t t) const { return all_[s * count_ + t]; }

    // From now on whole drawings count alone.
    void forget_own_slices() {
        for (Relation& relation : all_) relation.alone = true;
    }

  private:
    std::size_t count_;
    std::vector<Relation> all_;
};

}  // namespace anatomesh
