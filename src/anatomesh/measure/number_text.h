// Numbers as text for people: the same in every locale.
#pragma once

#include <string>

namespace anatomesh {

// With a fixed number of decimals: fixed_text(2.5, 2) = "2.50". "inf" and "nan" for what is not finite.
std::string fixed_text(double value, int decimals);

// Share of a total in percent: percent_text(1, 8, 1) = "12.5 %"; "0 %" of nothing.
std::string percent_text(double part, double total, int decimals);

}  // namespace anatomesh
