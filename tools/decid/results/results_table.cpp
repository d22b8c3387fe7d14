// The table of results: see results_table.hpp.
#include "tools/decid/results/results_table.hpp"

#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "tools/decid/command.hpp"

namespace decid::tools {
namespace {

/// A number as JSON prints it; nothing for null.
std::string number_cell(const Json& value) {
  return value.is_number() ? value.dump() : std::string();
}

/// A file's name need not be UTF-8, the table is: other bytes are replaced.
std::string text_cell(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  const std::string clean = found->dump(-1, ' ', false, Json::error_handler_t::replace);
  return csv_cell(Json::parse(clean).get<std::string>());
}

std::string parameter_cells(const Json& parameter) {
  const auto interval = parameter.find("interval90");
  const bool known = interval != parameter.end();
  return ',' + number_cell(parameter.at("value")) + ',' + (known ? number_cell(interval->at(0)) : "") + ',' +
         (known ? number_cell(interval->at(1)) : "");
}

}  // namespace

std::string results_table(const Json& recordings, const sim::ParameterTable& parameters) {
  std::string text = "file,trust";
  for (const std::string& name : parameters.names()) text += ',' + name + ',' + name + "_low90," + name + "_high90";
  text += ",error\n";
  for (const Json& recording : recordings) {
    text += text_cell(recording, "file") + ',' + text_cell(recording, "trust");
    if (const auto found = recording.find("parameters"); found != recording.end())
      for (const Json& parameter : *found) text += parameter_cells(parameter);
    else
      text.append(3 * parameters.size(), ',');
    text += ',' + text_cell(recording, "error") + '\n';
  }
  return text;
}

void add_table_option(const Command& command, std::string& table) {
  add_output_option(command, "--table", table, Written::csv,
                    "Write a CSV table with one line per recording, for spreadsheets and R");
}

}  // namespace decid::tools
