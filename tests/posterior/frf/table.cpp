#include "posterior/frf/table.hpp"

#include "sim/protocol/experiment.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

namespace {

frf::Table read(const std::string& text) {
  const TemporaryFolder folder;
  return frf::read_table(write_text(folder / "t.csv", text));
}

void check_refused(const std::string& text, Code code, std::string_view fact = {}) {
  INFO(text);
  check_error([&] { read(text); }, code, fact);
}

const std::string rows = "0.05,0.9,20\n0.4,1.8,-60\n1.1,0.8,-150\n";

}  // namespace

TEST_CASE("gain and phase are a complex response") {
  const frf::Table table = read("frequency_hz,gain,phase_deg\n" + rows);
  REQUIRE(table.rows.size() == 3);
  CHECK(table.rows[1].frequency_hz == 0.4);
  CHECK(near(table.rows[1].response.real(), 0.9, 1e-12));
  CHECK(near(table.rows[1].response.imag(), -1.8 * std::sqrt(0.75), 1e-12));
  CHECK(table.rows[1].stddev == 0.0);
  CHECK(table.rows[1].harmonics == 0);
  CHECK_FALSE(table.has_confidence());
}

TEST_CASE("columns are found by many names, in any order, with units") {
  const frf::Table first = read("frequency_hz,gain,phase_deg\n" + rows);
  for (const char* text :
       {"Phase [deg];Gain;Freq (Hz)\n20;0,9;0,05\n-60;1,8;0,4\n-150;0,8;1,1\n",
        "f\tmagnitude\tphase\tsubject\nHz\t1\tdeg\t-\n0.05\t0.9\t20\ta\n0.4\t1.8\t-60\tb\n1.1\t0.8\t-150\tc\n",
        "frequency gain phase_rad\n0.05 0.9 0.34906585039886590\n0.4 1.8 -1.0471975511965976\n"
        "1.1 0.8 -2.6179938779914944\n"}) {
    INFO(text);
    const frf::Table other = read(text);
    REQUIRE(other.rows.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(other.rows[i].frequency_hz == first.rows[i].frequency_hz);
      CHECK(within(std::abs(other.rows[i].response - first.rows[i].response), 0.0, 1e-12));
    }
  }
}

TEST_CASE("kinds of confidence are one deviation") {
  const auto with = [](const std::string& header, const std::string& cells) {
    return read("frequency,gain,phase," + header + "\n0.05,0.9,20," + cells + "\n0.4,1.8,-60," + cells +
                "\n1.1,0.8,-150," + cells + "\n");
  };
  CHECK(with("SD", "0.1").rows[1].stddev == 0.1);
  CHECK(with("SD", "0.1").confidence == "SD");
  CHECK(with("sem", "0.1").rows[1].stddev == 0.1);
  CHECK(near(with("ci95", "0.196").rows[1].stddev, 0.1, 1e-4));
  CHECK(near(with("radius95", "0.2448").rows[1].stddev, 0.1, 1e-3));
  CHECK(near(with("coherence,cycles", "0.5,8").rows[1].stddev, 1.8 * 0.25, 1e-12));
  CHECK(with("coherence,cycles", "0.5,8").rows[1].coherence == 0.5);
  CHECK(with("SD", "0.1").rows[1].coherence == 0.0);
  // Rounded to 0 and 1: half a unit of the last decimal place is left.
  CHECK(near(with("coherence,cycles", "0.00,8").rows[1].coherence, 0.05, 1e-12));
  const frf::Table rounded =
      read("frequency,gain,phase,coherence,cycles\n0.05,0.9,20,1.00,8\n0.4,1.8,-60,0.37,8\n1.1,0.8,-150,0.00,8\n");
  CHECK(near(rounded.rows[0].coherence, 0.995, 1e-12));
  CHECK(rounded.rows[1].coherence == 0.37);
  CHECK(near(rounded.rows[2].coherence, 0.005, 1e-12));
  CHECK(rounded.rows[2].stddev > 0.0);
  const frf::Table several = with("coherence,cycles,harmonics", "0.5,8,4");
  CHECK(near(several.rows[1].stddev, 1.8 * 0.125, 1e-12));
  CHECK(several.rows[1].harmonics == 4);
}

TEST_CASE("tables that cannot be used are errors") {
  check_refused("gain,phase_deg\n0.9,20\n1.8,-60\n0.8,-150\n", Code::column_missing, "'gain', 'phase_deg'");
  check_refused("frequency,phase\n0.05,20\n0.4,-60\n1.1,-150\n", Code::column_missing);
  check_refused("frequency,gain\n0.05,0.9\n0.4,1.8\n1.1,0.8\n", Code::column_missing);
  check_refused("frequency,gain,gain,phase\n0.05,0.9,1,20\n", Code::column_ambiguous, "2 columns");
  check_refused("frequency,gain_db,phase\n" + rows, Code::unit_unknown, "gain_db");
  check_refused(rows, Code::column_missing, "frequency_hz");
  check_refused("frequency,gain,phase\n0,0.9,20\n0.4,1.8,-60\n1.1,0.8,-150\n", Code::value_invalid, "line 2");
  check_refused("frequency,gain,phase\n-0.05,0.9,20\n0.4,1.8,-60\n", Code::value_invalid, "line 2");
  check_refused("frequency,gain,phase\n0.4,1.8,-60\n0.05,0.9,20\n1.1,0.8,-150\n", Code::value_invalid, "line 3");
  check_refused("frequency,gain,phase\n0.05,0.9,20\n0.4,1.8,-60\n0.4,1.7,-61\n", Code::value_invalid, "line 4");
  check_refused("frequency,gain,phase\n0.05,-0.9,20\n0.4,1.8,-60\n1.1,0.8,-150\n", Code::value_invalid, "line 2");
  check_refused("frequency,gain,phase\n0.05,-3.1,20\n0.4,5.2,-60\n1.1,-8,-150\n", Code::value_invalid, "20 log10");
  check_refused("frequency,gain,phase\n0.05,,20\n0.4,1.8,-60\n1.1,0.8,-150\n", Code::value_missing, "line 2");
  check_refused("frequency,gain,phase\n0.05,0.9,x\n0.4,1.8,-60\n1.1,0.8,-150\n", Code::value_invalid, "line 2");
  check_refused("frequency,gain,phase\n0.05,0.9,20\n0.4,1.8,-60\n", Code::setting_out_of_range, "2 rows");
  check_refused("frequency,gain,phase\n0.05,0.9,0.3\n0.4,1.8,-1\n1.1,0.8,-2.6\n", Code::unit_unknown, "phase_rad");
  const auto with = [](const std::string& header, const std::string& cells) {
    return "frequency,gain,phase," + header + "\n0.05,0.9,20," + cells + "\n0.4,1.8,-60," + cells + "\n1.1,0.8,-150," +
           cells + "\n";
  };
  check_refused(with("sd", "0"), Code::value_invalid, "line 2, sd");
  check_refused(with("sd,ci95", "0.1,0.2"), Code::column_ambiguous, "95");
  check_refused(with("coherence", "0.5"), Code::column_missing);
  check_refused(with("coherence,cycles", "1.5,8"), Code::value_invalid, "1.5 is");
  check_refused(with("coherence,cycles", "-0.1,8"), Code::value_invalid, "-0.1 is");
  check_refused(with("coherence,cycles", "0.5,0.5"), Code::value_invalid, "0.5 is");
  check_refused(with("harmonics", "1.5"), Code::value_invalid, "1.5 is");
  check_error([] { frf::read_table("/no/such/table.csv"); }, Code::file_missing, "/no/such/table.csv");
}

TEST_CASE("the last line counts, unless it is cut") {
  std::string eleven = "frequency_hz,gain,phase_deg\n";
  for (int i = 0; i < 10; ++i) eleven += "1." + std::to_string(i) + ",0.50,-12.3\n";
  const frf::Table typed = read(eleven + "2.2,0.14,-137");
  REQUIRE(typed.rows.size() == 11);
  CHECK(near(std::abs(typed.rows.back().response), 0.14, 1e-12));
  check_refused(eleven + "2.2,0.13", Code::file_damaged, "line 12");
  check_refused("frequency,gain,phase,sd\n0.05,0.9,20,0.1\n0.4,1.8,-60,0.1\n1.1,0.8,-150,0.1\n2.2,0.1395,-13",
                Code::file_damaged, "line 5");
}

TEST_CASE("columns in units that they cannot have are errors") {
  const auto with = [](const std::string& gain, const std::string& header, const std::string& cells) {
    return "frequency," + gain + ",phase_deg," + header + "\n0.05,0.9,20," + cells + "\n0.4,1.8,-60," + cells +
           "\n1.1,0.8,-150," + cells + "\n";
  };
  for (const char* name :
       {"sd (%)", "SD [%]", "sd_percent", "gain_sd (dB)", "sem_pct", "sd (deg)", "sd_mm", "ci95 (%)", "radius95 (%)"})
    check_refused(with("gain", name, "3"), Code::unit_unknown, name);
  for (const char* name : {"gain (%)", "gain [dB]", "magnitude_db", "gain (mm/deg)", "gain (deg)"})
    check_refused(with(name, "sd", "0.1"), Code::unit_unknown, name);
  check_refused(with("gain", "coherence (%),cycles", "0.5,8"), Code::unit_unknown, "coherence (%)");
  check_refused("frequency (rad/s),gain,phase_deg\n" + rows, Code::unit_unknown, "rad/s");
  check_refused("freq_mhz,gain,phase_deg\n" + rows, Code::unit_unknown, "freq_mhz");
  check_refused("frequency,gain,phase (%)\n" + rows, Code::unit_unknown, "phase (%)");
  check_refused("frequency,gain,phase,sd\nHz,-,deg,%\n0.05,0.9,20,3\n0.4,1.8,-60,3\n1.1,0.8,-150,3\n",
                Code::unit_unknown, "sd (%)");
  check_refused("frequency,gain,phase\nHz,%,deg\n" + rows, Code::unit_unknown, "gain (%)");
  for (const char* name : {"sd (deg/deg)", "sd [-]", "sd"})
    CHECK(read(with("gain", name, "0.1")).rows[1].stddev == 0.1);
  CHECK(read("f (Hz),Gain (deg/deg),Phase [mrad]\n0.05,0.9,200\n0.4,1.8,-600\n1.1,0.8,-1500\n").rows.size() == 3);
}

TEST_CASE("two columns of one quantity are errors, whatever their names") {
  const auto check = [](const std::string& header, const std::string& cells, std::string_view fact) {
    check_refused(header + "\n0.05," + cells + "\n0.4," + cells + "\n1.1," + cells + "\n", Code::column_ambiguous,
                  fact);
  };
  check("frequency,gain,phase,sd,sem", "0.9,20,0.1,0.2", "'sd', 'sem'");
  check("frequency,gain,phase,ci95,gain_ci_95", "0.9,20,0.1,0.2", "'ci95', 'gain_ci_95'");
  check("frequency,gain,magnitude,phase", "0.9,0.8,20", "'gain', 'magnitude'");
  check("freq,frequency_hz,gain,phase", "0.05,0.9,20", "'freq', 'frequency_hz'");
  check("frequency,gain,phase_deg,phase_rad", "0.9,20,0.3", "'phase_deg', 'phase_rad'");
}

TEST_CASE("small phases are degrees if their name says so") {
  const std::string small = "\n0.05,0.9,0.3\n0.4,1.8,-1\n1.1,0.8,-2.6\n";
  check_refused("frequency,gain,phase" + small, Code::unit_unknown, "phase_deg or phase_rad");
  const auto phase_deg = [&](const char* name) {
    return std::arg(read("frequency,gain," + std::string(name) + small).rows[2].response) / sim::rad_per_deg;
  };
  for (const char* name : {"phase_deg", "phase (deg)", "Phase [\u00B0]"}) CHECK(near(phase_deg(name), -2.6, 1e-9));
  CHECK(near(phase_deg("phase_rad"), -2.6 / sim::rad_per_deg, 1e-9));
}

TEST_CASE("gains that no sway over a tilt has are errors") {
  for (const char* gain : {"1e-200", "9e-7", "1001", "1e200"})
    check_refused("frequency,gain,phase\n0.05,0.9,20\n0.4," + std::string(gain) + ",-60\n1.1,0.8,-150\n",
                  Code::value_invalid, "line 3, gain");
}
