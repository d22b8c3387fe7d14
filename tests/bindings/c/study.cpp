// A study through C: refusals, and a callback that stops it. test_package.py and test_functions.m compare its JSON with
// the program's, to the byte.
#include "base/text.hpp"
#include "tests/bindings/c/owned.hpp"

namespace decid {
namespace {

using namespace test;

/// A sheet of two persons in two sessions, all with the same recording.
std::string sheet_in(const TemporaryFolder& folder) {
  std::string csv = "time,sway_rad\n";
  const std::vector<double> sway_rad = simulated(3);
  for (std::size_t i = 0; i < sway_rad.size(); ++i)
    csv += format("%.2f,%.17g\n", static_cast<double>(i) * 0.01, sway_rad[i]);
  std::string sheet = "participant_id,group,session,file,age\n";
  for (const char* name : {"a1", "a2", "b1", "b2"}) {
    write_text(folder / (std::string(name) + ".csv"), csv);
    sheet += format("%c,%s,%c,%s.csv,6%c\n", name[0], "all", name[1], name, name[1]);
  }
  return write_text(folder / "s.csv", sheet).string();
}

decid_study_options defaults() {
  decid_study_options options;
  decid_study_defaults(&options, sizeof options);
  return options;
}

TEST_CASE("C: studies that cannot be made are refused, and a callback stops fits") {
  const TemporaryFolder folder;
  const std::string sheet = sheet_in(folder);
  decid_study* study = nullptr;
  const auto run = [&](const decid_study_options& options) {
    return decid_study_run(built_in(), sheet.c_str(), &options, &study);
  };
  refused(decid_study_run(nullptr, sheet.c_str(), nullptr, &study), Code::setting_missing, "model");
  refused(decid_study_run(built_in(), nullptr, nullptr, &study), Code::setting_missing, "sheet");
  refused(decid_study_run(built_in(), "none.csv", nullptr, &study), Code::file_missing, "none.csv");
  decid_study_options options = defaults();
  options.by_group = 1;
  refused(run(options), Code::setting_out_of_range, "1 group");
  options = defaults();
  options.joint = "participant_id";
  refused(run(options), Code::setting_conflict, "joint");
  options.fit = 1;
  options.free = "theta:session";
  options.within = "session";
  refused(run(options), Code::setting_conflict, "free");
  options.within = options.joint = nullptr;
  refused(run(options), Code::setting_conflict, "free");
  options = defaults();
  options.controllers = "dec,ic";
  refused(run(options), Code::setting_conflict, "controllers");
  options.fit = 1;
  options.joint = "participant_id";
  refused(run(options), Code::setting_conflict, "joint");
  options.joint = nullptr;
  options.controllers = "dec,pid";
  refused(run(options), Code::setting_unknown, "controllers");
  options.controllers = "dec,ic,dec";
  refused(run(options), Code::setting_conflict, "controllers");
  options = defaults();
  options.size = 1;
  refused(run(options), Code::size_mismatch);
  options = defaults();
  options.fit = 1;
  options.max_draws = 7;
  refused(run(options), Code::setting_out_of_range, "max_draws");
  options.max_draws = 8;
  options.progress = [](void*, double, const char*) { return 1; };
  CHECK(run(options) == DECID_STOPPED);
  CHECK(study == nullptr);
  CHECK(decid_study_json(nullptr) == nullptr);
  decid_study_free(nullptr);
}

}  // namespace
}  // namespace decid
