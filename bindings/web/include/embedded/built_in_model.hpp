// As decid_embed() makes it where the model lies in the program (cmake/DecidEmbed.cmake).
#pragma once

#include <string_view>

namespace decid::embedded {
std::string_view built_in_model();
}
