// The page of a frequency response's fit: see frf_page.hpp. frf_fit.js draws it.
#include "tools/report/frf_page.hpp"

#include "embedded/frf_fit_js.hpp"
#include "tools/report/page.hpp"

namespace decid::tools {

std::string frf_page(Json answer) {
  answer["fit"].erase("seconds");
  return page_html({.title = "Frequency response",
                    .lead = "Controllers that have a published frequency response, and the ranges of their parameters.",
                    .script = embedded::frf_fit_js()},
                   answer);
}

}  // namespace decid::tools
