// The built-in model of a page: a file that lies beside the program, as the page has two programs and one model.
#include "embedded/built_in_model.hpp"

#include <string>

#include "base/files/file.hpp"

namespace decid::embedded {

std::string_view built_in_model() {
  static const std::string content = read_file("/decid/built_in.safetensors");
  return content;
}

}  // namespace decid::embedded
