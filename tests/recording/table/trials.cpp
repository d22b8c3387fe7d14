// Several recordings in one file of text: a column distinguishes them, and without it they are refused.
#include "recording/table/detail/trials.hpp"

#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

using Strings = std::vector<std::string>;

/// Two recordings of 1, 2, 3 degrees and twice that, at 100 Hz.
constexpr const char* two =
    "subject,trial,time,angle_deg\n"
    "s1,a,0,1\ns1,a,0.01,2\ns1,a,0.02,3\n"
    "s1,b,0,2\ns1,b,0.01,4\ns1,b,0.02,6\n";

Strings trials(const std::string& csv, const std::string& by) {
  const TemporaryFolder folder;
  return list_trials(write_text(folder / "r.csv", csv), {.trial_column = by});
}

void check_trial(const std::string& csv, const std::string& by, const std::string& trial, double factor) {
  const Recording recording = read(csv, {.trial_column = by, .trial = trial});
  CHECK(recording.file.ends_with("r.csv#" + trial));
  CHECK(recording.rate_hz == 100.0);
  const auto& rad = recording.signals.at(com_sway).rad;
  REQUIRE(rad.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) CHECK(rad[k] == factor * static_cast<double>(k + 1) * sim::rad_per_deg);
}

}  // namespace

TEST_CASE("a column of trials makes each of its values a recording") {
  CHECK(trials(two, "trial") == Strings{"a", "b"});
  CHECK(trials(two, "2") == Strings{"a", "b"});
  check_trial(two, "trial", "a", 1.0);
  check_trial(two, "trial", "b", 2.0);
  CHECK(trials(two, "subject,trial") == Strings{"s1,a", "s1,b"});
  check_trial(two, "subject,trial", "s1,b", 2.0);
  // Rows of a trial need not lie together; those without a value belong to none.
  const std::string mixed = "time,angle_deg,run\n0,1,x\n0,2,y\n7,5,\n0.01,2,x\n0.01,4,y\n0.02,3,x\n0.02,6,y\n9,9,NA\n";
  CHECK(trials(mixed, "run") == Strings{"x", "y"});
  check_trial(mixed, "run", "x", 1.0);
  check_trial(mixed, "run", "y", 2.0);
  check_error(
      [] { read("trial,time\n3,0\n3,0.01\n3,0.02\n4,0\n4,0.01\n4,0.02\n", {.trial_column = "trial", .trial = "3"}); },
      Code::column_missing, "'trial'");
  // A wrong cell is an error of its own recording, at its line in the file.
  const std::string wrong = "time,angle_deg,run\n0,1,x\n0.01,2,x\n0.02,3,x\n0,2,y\n0.01,oops,y\n0.02,6,y\n";
  check_trial(wrong, "run", "x", 1.0);
  check_error(reading(wrong, {.trial_column = "run", .trial = "y"}), Code::value_invalid, "line 6");
}

TEST_CASE("columns that do not tell recordings apart, and trials that there are not, are refused") {
  check_error([] { trials(two, "block"); }, Code::column_missing, "'block'");
  check_error([] { trials(two, "subject,block"); }, Code::column_missing, "'block'");
  check_error([] { trials("time,angle_deg,run\n0,1,a\n0.01,2,b\n0.02,3,c\n", "run"); }, Code::column_unsuitable,
              "3 values");
  check_error([] { trials("time,angle_deg,run\n0,1,\n0.01,2,\n0.02,3,\n", "run"); }, Code::column_unsuitable, "'run'");
  check_error(reading(two, {.trial_column = "trial", .trial = "c"}), Code::setting_unknown, "'c'");
  check_error(reading(two, {.trial_column = "trial"}), Code::setting_unknown);
}

TEST_CASE("a signal does not number recordings") {
  std::string text = "trial,time,sway_deg\n";
  for (int k = 0; k < 2000; ++k) text += format("%d,%.2f,%.3f\n", k / 80, 0.01 * (k % 80), 0.001 * (k % 900));
  const TemporaryFolder folder;
  const std::filesystem::path path = write_text(folder / "t.csv", text);
  check_error([&] { list_trials(path, {.trial_column = "sway_deg"}); }, Code::column_unsuitable, "900 values");
  check_error([&] { list_trials(path, {.trial_column = "time"}); }, Code::column_unsuitable, "80 values");
  CHECK(list_trials(path, {.trial_column = "trial"}).size() == 25);
}

TEST_CASE("several recordings below each other are refused without --trial, with a rate too") {
  for (const RecordingOptions& options : {RecordingOptions{}, RecordingOptions{.rate_hz = 100.0}}) {
    check_error(reading(two, options), Code::recording_ambiguous, "line 5");
    check_error(reading("block,angle_deg\n1,1\n1,2\n1,3\n2,1\n2,2\n", options), Code::recording_ambiguous, "line 5");
    // Times start again, at their beginning or later.
    for (const char* second : {"0", "0.05"}) {
      std::string text = "time,angle_deg\n";
      for (int k = 0; k < 40; ++k) text += std::to_string(k * 0.01) + "," + std::to_string(k % 7) + "\n";
      for (int k = 0; k < 40; ++k)
        text += std::to_string(std::stod(second) + k * 0.01) + "," + std::to_string(k % 7) + "\n";
      check_error(reading(text, options), std::string(second) == "0" ? Code::recording_ambiguous : Code::times_uneven,
                  "line 42");
    }
  }
  check_one_two_three("trial,time,angle_deg\n4,0,1\n4,0.01,2\n4,0.02,3\n");
  check_one_two_three("trial,time,angle_deg\n4,0,1\n,0.01,2\n4,0.02,3\n");
  check_one_two_three("block,time,angle_deg\n1,0,1\n1,0.01,2\n2,0.02,3\n", {.is_one_trial = true});
  // A single wrong time is another fault.
  check_error(reading("time,angle_deg\n0,1\n0.01,2\n50,3\n0.03,1\n0.04,2\n"), Code::times_uneven, "line 5");
}

namespace {

/// Rows "0.00,1" and so on of a recording of 0.3 s, behind `first`.
std::string rows_behind(const std::string& first, double begin_s = 0.0) {
  std::string text;
  for (int k = 0; k < 30; ++k) text += first + std::to_string(begin_s + k * 0.01) + "," + std::to_string(k % 7) + "\n";
  return text;
}

std::string remedy_of(const std::string& csv, const RecordingOptions& options = {}) {
  return error_of(reading(csv, options)).remedy();
}

/// The --trial that the refusal of the file advises; each recording that it makes has 30 samples at 100 Hz.
std::string advised(const std::string& csv, std::size_t recordings) {
  const std::string remedy = remedy_of(csv);
  INFO(remedy);
  const std::size_t begin = remedy.find("trial_column '");
  REQUIRE(begin != std::string::npos);
  const std::string by = remedy.substr(begin + 14, remedy.find('\'', begin + 14) - begin - 14);
  CHECK(trials(csv, by).size() == recordings);
  for (const std::string& trial : trials(csv, by)) {
    const Recording recording = read(csv, {.trial_column = by, .trial = trial});
    CHECK(recording.signals.samples() == 30);
    CHECK(near(recording.rate_hz, 100.0, 1e-9));
  }
  return by;
}

bool advises(const std::string& csv, const std::string& advice, const RecordingOptions& options = {}) {
  return remedy_of(csv, options).find(advice) != std::string::npos;
}

}  // namespace

TEST_CASE("the advised --trial works, and takes as many columns as tell the recordings apart") {
  const auto four = [](const std::string& names, const std::vector<std::string>& firsts) {
    std::string text = names + ",time,com_sway_deg\n";
    for (const std::string& first : firsts) text += rows_behind(first + ",");
    return text;
  };
  CHECK(advised(four("trial", {"1", "2"}), 2) == "trial");
  CHECK(advised(four("condition", {"open", "closed"}), 2) == "condition");
  CHECK(advised(four("subject,trial", {"a,1", "a,2", "b,1", "b,2"}), 4) == "subject,trial");
  CHECK(advised(four("name,condition,lab", {"a,o,x", "a,c,x", "b,o,x", "b,c,x"}), 4) == "name,condition");
  CHECK(advised(four("\"subject, id\",trial", {"a,1", "a,2", "b,1", "b,2"}), 4) == "1,trial");
  CHECK(advised(four("block,block", {"1,1", "2,2"}), 2) == "1");
  // Two trials per subject that no column distinguishes; and trials whose numbers repeat.
  using Labelled = std::pair<std::string, std::vector<std::string>>;
  for (const Labelled& one :
       {Labelled{"subject", {"a", "a", "b", "b"}}, {"trial", {"1", "2", "1", "2"}}, {"subject", {"a", "a"}}}) {
    CHECK_FALSE(advises(four(one.first, one.second), "trial_column '"));
    CHECK(advises(four(one.first, one.second), "its own file"));
  }
  // The column that was given is not enough.
  CHECK(advises(four("subject,run", {"a,1", "a,2"}), "trial_column 'subject,run'",
                {.trial_column = "subject", .trial = "a"}));
}

TEST_CASE("--trial none is advised where all rows can be read as one recording, and nowhere else") {
  const std::string head = "trial,time,com_sway_deg\n";
  const std::string goes_on = head + rows_behind("1,") + rows_behind("2,", 0.3);
  CHECK(advises(goes_on, "trial_column none"));
  CHECK(read(goes_on, {.is_one_trial = true}).signals.samples() == 60);
  CHECK(advised(goes_on, 2) == "trial");
  for (const std::string& not_one : {rows_behind("1,") + rows_behind("2,"), rows_behind("1,") + "Mean,,3\n"})
    CHECK_FALSE(advises(head + not_one, "trial_column none"));
}

TEST_CASE("a column called trial that holds the times is exchanged with the column of time") {
  std::string text = "trial,time,com_sway_deg\n";
  for (int k = 0; k < 30; ++k) text += std::to_string(k * 0.01) + ",1," + std::to_string(k % 7) + "\n";
  check_error(reading(text), Code::times_uneven, "'time'");
  CHECK(read(text, {.rate_hz = 100.0}).signals.samples() == 30);
}

TEST_CASE("a column of sway that holds the times is exchanged with the column of time") {
  std::string text = "com_sway_deg,time\n";
  for (int k = 0; k < 60; ++k) text += std::to_string(k * 0.01) + "," + std::to_string(k % 30 * 0.01) + "\n";
  check_error(reading(text), Code::recording_ambiguous, "'time'");
}

TEST_CASE("names of recordings and people in other words, and other languages") {
  const auto two_of = [](const std::string& name, const char* second, double begin_s = 0.0) {
    return name + ",time,com_sway_deg\n" + rows_behind("1,") + rows_behind(second, begin_s);
  };
  for (const char* name : {"rep",    "pid",       "subj",      "Patient",      "Proband", "VP",    "Vpn",
                           "Vpn_Nr", "Versuch",   "Durchgang", "Wiederholung", "sujet",   "essai", "run",
                           "Run No", "condition", "cond",      "Bedingung",    "id",      "eyes",  "set"}) {
    CAPTURE(std::string(name));
    check_error(reading(two_of(name, "2,")), Code::recording_ambiguous, name);
    CHECK(advised(two_of(name, "2,"), 2) == name);
    CHECK(read(two_of(name, "1,", 0.3)).signals.samples() == 60);  // a constant
    // Cycles and conditions of one recording, whose times run on.
    const Recording whole = read(two_of(name, "2,", 0.3));
    CHECK(whole.signals.samples() == 60);
    CHECK(whole.change.starts_with("'" + std::string(name) + "' changes from '1' to '2' at 0.3 s"));
    CHECK(read(std::string(name) + ",com_sway_deg\n1,1\n1,2\n2,3\n2,1\n", {.rate_hz = 100.0}).signals.samples() == 4);
  }
  // A name that divides always counts alone.
  check_error(reading("VP,trial,time,com_sway_deg\n" + rows_behind("1,1,") + rows_behind("2,2,", 0.3)),
              Code::recording_ambiguous, "'trial' changes");
  // A state of the stimulus comes back; a column of samples does not distinguish recordings.
  for (const char* name : {"condition", "run", "id", "eyes"}) {
    CAPTURE(std::string(name));
    std::string returns = std::string(name) + ",time,com_sway_deg\n", counts = returns;
    for (int k = 0; k < 60; ++k) {
      const std::string rest = "," + std::to_string(0.01 * k) + "," + std::to_string(k % 7) + "\n";
      returns += std::to_string(k / 20 % 2) + rest;
      counts += std::to_string(k) + rest;
    }
    CHECK(read(returns).signals.samples() == 60);
    CHECK(read(counts).signals.samples() == 60);
  }
}

TEST_CASE("more than ten stretches count if their column is called as recordings are, and if they are long") {
  const auto change = [](const std::string& name, double stretch_s) {
    std::string text = "time,com_sway_deg," + name + "\n";
    for (int k = 0; k < 1500; ++k)
      text += std::to_string(k * 0.02) + "," + std::to_string(k % 7) + "," +
              std::to_string(static_cast<int>(k * 0.02 / stretch_s)) + "\n";
    const Recording made = read(text);
    CHECK_FALSE(made.change_s);
    return made.change;
  };
  CHECK(change("rep", 2.5).starts_with("'rep' changes from '0' to '1' at 2.5 s"));
  CHECK(change("who", 2.5).empty());
  CHECK(change("id", 1.0).empty());
}

TEST_CASE("a column of few values that change in stretches may tell recordings apart") {
  const auto change = [](const std::string& second, const RecordingOptions& options = {}) {
    return read(
               "time,com_sway_deg,who\n" +
                   [&] {
                     std::string text;
                     for (int k = 0; k < 60; ++k)
                       text += std::to_string(k * 0.01) + "," + std::to_string(k % 7) + "," +
                               (k < 30 ? "Ann" : second) + "\n";
                     return text;
                   }(),
               options)
        .change;
  };
  CHECK(change("Bob").starts_with("'who' changes from 'Ann' to 'Bob' at 0.3 s"));
  CHECK(change("Bob").ends_with("trial_column 'who' separates them"));
  CHECK(change("Ann").empty());
  CHECK(change("Bob", {.is_one_trial = true}).empty());
  std::string signal = "time,com_sway_deg,a,b\n";  // a signal, and a state that comes back
  for (int k = 0; k < 60; ++k)
    signal += std::to_string(k * 0.01) + "," + std::to_string(k % 7) + "," + std::to_string(k) + "," +
              (k / 10 % 2 ? "on" : "off") + "\n";
  CHECK(read(signal).change.empty());
  // A column of two values that is not called as recordings are may be a trigger.
  for (const std::string name : {"trigger", "block", "eyes"}) {
    std::string text = "time,com_sway_deg," + name + "\n";
    for (int k = 0; k < 60; ++k)
      text += std::to_string(k * 0.01) + "," + std::to_string(k % 7) + "," + (k < 20 ? "0" : "5") + "\n";
    const Recording made = read(text, {.is_one_trial = name == "block"});
    CHECK(made.change_s.has_value() == (name == "trigger"));
    if (made.change_s) CHECK(near(*made.change_s, 0.2, 1e-9));
  }
}
