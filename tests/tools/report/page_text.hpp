// What tests look for in a page.
#pragma once

#include <string>

namespace decid::test {

inline std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++found;
  return found;
}

/// The JSON block, from its mark to the first end of a script element: what a browser would take.
inline std::string block_of(const std::string& page) {
  const std::string mark = "id=\"report-data\">";
  const std::size_t start = page.find(mark) + mark.size();
  return page.substr(start, page.find("</script", start) - start);
}

}  // namespace decid::test
