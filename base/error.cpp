// The library's error type: see error.hpp.
#include "base/error.hpp"

#include <utility>

namespace decid {

Error::Error(std::string where, std::string problem, std::string remedy)
    : std::runtime_error(where + ": " + problem + "; " + remedy),
      where_(std::move(where)),
      problem_(std::move(problem)),
      remedy_(std::move(remedy)) {}

}  // namespace decid
