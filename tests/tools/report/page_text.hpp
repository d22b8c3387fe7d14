// Reads data and text from a page for tests.
#pragma once

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace decid::test {

inline std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++found;
  return found;
}

/// Returns a JSON block, from its mark to the first end of a script element, as a browser would read it.
inline std::string block_of(const std::string& page, const std::string& id = "report-data") {
  const std::string mark = "id=\"" + id + "\">";
  const std::size_t start = page.find(mark) + mark.size();
  return page.substr(start, page.find("</script", start) - start);
}

/// Checks that a page is one whole file that loads nothing.
inline void check_whole(const std::string& page) {
  CHECK(page.starts_with("<!doctype html>"));
  CHECK(page.ends_with("</html>\n"));
  for (const char* part : {"src=\"", "@import", "<link", "<img", "fetch(", "XMLHttpRequest", "{{title}}", "{{css}}",
                           "{{lead}}", "{{data}}", "{{script_hash}}", "{{page_js}}"}) {
    CAPTURE(part);
    CHECK(page.find(part) == std::string::npos);
  }
}

/// Returns the data of a page of recordings, each with the details that a browser reads when the user opens it.
inline nlohmann::json data_of(const std::string& page) {
  nlohmann::json data = nlohmann::json::parse(block_of(page));
  for (std::size_t i = 0; i < data["recordings"].size(); ++i)
    data["recordings"][i].update(nlohmann::json::parse(block_of(page, "details-" + std::to_string(i + 1))));
  return data;
}

}  // namespace decid::test
