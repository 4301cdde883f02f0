#pragma once
// Twin of the contact point selection (the source, §6.10.1, algorithm 3; rules 15 and 16).

#include "ipm_mapping/fpga/contact_points.hpp"
#include "ipm_mapping/fpga/free_space.hpp"

namespace ipm_mapping::fpga {

/// The selected contacts, one an obstacle, as contactWord()s in bearing order.
using SelectedContacts = WordList<std::uint32_t>;

/// Index of the peak that a contact serves: the nearest one, equally near the lower bearing.
/// There has to be one.
[[nodiscard]] int servedPeak(const Peaks& peaks, int bearing);

void selectContacts(const Contacts& cor, const Peaks& peaks, int bearing_tolerance,
                    SelectedContacts& selected);

}  // namespace ipm_mapping::fpga
