// Files of programs that are neither text nor MAT-files, known by their first bytes. Not installed.
#pragma once

#include <string>
#include <string_view>

namespace decid::dataset {

/// Throws Error for a file that is something else than a table: what it is, and what to do. `where` names it, `end` is
/// the end of its name, lower case: ".xls".
void refuse_foreign(std::string_view bytes, const std::string& where, std::string_view end);

}  // namespace decid::dataset
