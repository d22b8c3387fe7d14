// Text in and out of the command line: numbers as people and files read them, parameters given as NAME=VALUE.
#pragma once

#include <string>
#include <vector>

#include "sim/parameters.hpp"

namespace decid::tools {

/// printf's formatting into a string.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

/// Control characters become question marks: one line, whatever a file's name holds.
std::string one_line(std::string text);

/// " N m/rad", to stand behind a number; nothing for a parameter that is a plain number.
std::string unit_after(const sim::ParameterInfo& info);

/// "Kp=900,Kd=250,...": all seven, by name ("Kp_pass") or option name ("kp-pass"), in any order. Throws Error.
sim::Parameters parameters_from_text(const std::string& text, const std::string& where);

/// A CSV file: a header and rows of numbers, `digits` significant ones.
std::string csv(const std::vector<std::string>& header, const std::vector<std::vector<double>>& columns, int digits);

}  // namespace decid::tools
