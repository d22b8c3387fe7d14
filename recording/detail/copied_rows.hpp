// Rows that a program wrote twice. Not installed.
#pragma once

#include "base/warning.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Drops rows that equal the row before them in every column as long as the time, with an info that counts them.
/// Returns true if there are any. Does nothing if a row has the time of the row before it, and other values: then its
/// time is wrong.
bool drop_copied_rows(Table& table, int time, Warnings& warnings);

}  // namespace decid::recording
