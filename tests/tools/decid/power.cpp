// decid power: predicted power and persons, from given standard deviations and from simulated recordings.
#include "tests/near.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

TEST_CASE("decid/power: given standard deviations have the power of Cohen's table") {
  const std::string same =
      "power --json --difference delay=0.01 --participant-sd delay=0.016 --measurement-sd delay=0.012 "
      "--participants 64 ";
  const Json found = run_json(same);
  CHECK(found["participants"] == 64);
  const Json& delay = found["parameters"].at(0);
  CHECK(delay["name"] == "delay");
  CHECK(near(delay["power"].get<double>(), 0.801459557922, 1e-7));  // 0.5 standard deviations, 64 per group
  CHECK(delay["participants_needed"] == 64);
  CHECK(delay["trials_needed"] == 1);
  // Without measurement error the power is 94%; 20 participants per group never have 80%.
  CHECK(run_json(same + "--power 0.9")["parameters"][0]["trials_needed"].get<int>() > 1);
  CHECK(run_json("power --json --difference delay=0.01 --participant-sd delay=0.016 --measurement-sd delay=0.012 "
                 "--participants 20")["parameters"][0]["trials_needed"]
            .is_null());
  CHECK(run_json(same + "--power 0.9")["parameters"][0]["participants_needed"] == 86);  // Cohen's table, too
  // Seven intervals that hold together: a difference of 2.83 standard errors against 2.7 of them.
  const Json together = run_json(same + "--intervals 7");
  CHECK(together["intervals"] == 7);
  CHECK(within(together["parameters"][0]["power"].get<double>(), 0.54, 0.02));
  CHECK(together["parameters"][0]["participants_needed"].get<int>() > 95);
  // Per cent are of the mean; four trials quarter the recording's variance.
  const Json other = run_json(
      "power --difference kp=-15% --at Kp=800 --participant-sd Kp=10% --measurement-sd Kp=60 --trials 4 --json");
  CHECK(near(other["parameters"][0]["difference"].get<double>(), -120.0, 1e-12));
  CHECK(near(other["parameters"][0]["participant_sd"].get<double>(), 80.0, 1e-12));
  CHECK(other["trials"] == 4);
  const Json over_mgh = run_json("power --difference Kp/mgh=-0.1 --at kp/mgh=1 --measurement-sd Kp/mgh=0.05 --json"),
             &gain = over_mgh["parameters"][0];
  CHECK(near(gain["mean"].get<double>(), 838.98, 1e-3));  // m g h
  CHECK(near(gain["difference"].get<double>(), -0.1 * gain["mean"].get<double>(), 1e-9));
  CHECK(near(gain["measurement_sd"].get<double>(), 0.05 * gain["mean"].get<double>(), 1e-9));
  check_refused("power --difference Kp/mgh=-15% --measurement-sd Kp=60", "--difference");
  CHECK(run_json("power --difference kp=30 --measurement-sd Kp=20 --paired --json")["paired"] == true);
}

TEST_CASE("decid/power: the JSON names its call, which computes it again") {
  const Folder folder;
  const std::string saved = folder / "p.json";
  const std::string model = DECID_SOURCE_DIR "/models/built_in.safetensors";
  write_text(saved, run_ok("power --json --difference delay=0.02 --measurement-sd delay=0.01 --model " + model).out);
  const Json found = read_json(saved);
  CHECK(found["command"] == "power");
  CHECK(found["seed"] == 1);
  REQUIRE(found["inputs"].size() == 1);
  CHECK(found["inputs"][0]["file"] == model);
  run_ok("rerun " + saved + " -o " + folder / "again.json");
  CHECK(read_text(folder / "again.json") == read_text(saved));
  // A protocol's file is an input of predicted fits.
  const Json by_fit =
      run_json("power --json --by fit --recordings 8 --difference delay=0.02" + with_brief_protocol(folder));
  REQUIRE(by_fit["inputs"].size() == 1);
  CHECK(by_fit["inputs"][0]["file"] == folder / "tiny.json");
}

TEST_CASE("decid/power: means, ranges and m g h are those of the protocol's body") {
  const Folder folder;
  std::string heavy = brief_protocol;
  heavy.insert(1, R"("body": {"participant": {"mass_kg": 100, "height_m": 1.9}}, )");
  const std::string protocol = "--protocol " + write_text(folder / "heavy.json", heavy).string();
  const Json found = run_json("power --json --quiet --by fit --recordings 8 --at Kp/mgh=1 --difference Kp/mgh=-0.15 " +
                              protocol),
             &kp = found["parameters"][0];
  const Json designed = run_json("design --json --quiet --draws 8 --at Kp/mgh=1 " + protocol);
  CHECK(kp["mean"] == designed["parameters"][0]["at"]);
  CHECK(kp["mean"].get<double>() > 990.0);  // the default body's m g h is 839 N m/rad
  CHECK(near(kp["difference"].get<double>(), -0.15 * kp["mean"].get<double>(), 1e-9));
  // A light body's range ends below the default body's middle.
  std::string light = brief_protocol;
  light.insert(1, R"("body": {"participant": {"mass_kg": 35, "height_m": 1.4}}, )");
  run_ok("power --quiet --by fit --recordings 8 --at Kp=250 --difference Kp=-30 --protocol " +
         write_text(folder / "light.json", light).string());
}

TEST_CASE("decid/power: recordings are simulated where their standard deviation is unknown") {
  const Json found = run_json("power --difference delay=0.02 --recordings 20 --sensor-noise 0.02 --json");
  const double sd = found["parameters"][0]["measurement_sd"].get<double>();
  CHECK(sd > 0.005);
  CHECK(sd < 0.06);
  const std::string units =
      run_ok(
          "power --difference Kp=-15% --difference Nv=0.1 --difference delay=0.02 --measurement-sd Kp=50 "
          "--measurement-sd Nv=0.1 --measurement-sd delay=0.01")
          .out;
  for (const char* line : {"\nKp, N m/rad ", "\nNv ", "\ndelay, s "}) CHECK(contains(units, line));
  // Simulated people have all parameters.
  run_ok("power --difference delay=0.02 --participant-sd Kp=90 --at Kp=800 --recordings 20 --json");
}

TEST_CASE("decid/power: a difference of 0 is refused, whatever the power comes from") {
  for (const char* options : {"", " --by fit", " --measurement-sd delay=0.01"})
    CHECK(run_decid("power --difference delay=0" + std::string(options)).code == 2);
}

TEST_CASE("decid/power: small values are legitimate; a difference that may be over m g h gets a note") {
  const auto notes = [](const std::string& options, const std::string& sd) {
    const Result found = run_ok("power " + options + " --measurement-sd " + sd);
    return found.err;
  };
  CHECK(notes("--difference Kp=0.5%", "Kp=60").empty());
  CHECK(notes("--difference delay=0.0003", "delay=0.01").empty());
  CHECK(contains(notes("--difference Kd=1", "Kd=20"), "1 m g h is 839"));
  CHECK(contains(notes("--difference Kp=-0.15", "Kp=50"), "-0.15 m g h is -125.8"));
  CHECK(notes("--difference Kd=1 --quiet", "Kd=20").empty());
}

TEST_CASE("decid/power: negative standard deviations and options without effect are refused") {
  const std::string power = "power --difference delay=0.02 ";
  for (const char* options : {"--participant-sd delay=-0.01", "--trial-sd delay=-1%", "--measurement-sd delay=-0.01",
                              "--measurement-sd delay=0.01 --by fit", "--measurement-sd delay=0.01 --recordings 400",
                              "--sensor-noise -1", "--sensor-noise 0.1 0.01", "--sensor-noise 0 0.1"}) {
    CAPTURE(std::string(options));
    const Result refused = run_decid(power + options);
    CHECK(refused.code == 2);
    CHECK(contains(refused.err, "decid: --"));
  }
}

TEST_CASE("decid/power: a prediction from few simulated people says so") {
  const std::string power = "power --difference delay=0.02 --recordings ";
  CHECK(contains(run_ok(power + "40").out, "10 simulated participants"));
  CHECK(run_json(power + "40 --json")["simulated_participants"] == 10);
  CHECK_FALSE(contains(run_ok(power + "400").out, "simulated participants"));
  CHECK(run_json("power --difference Kp=90 --measurement-sd Kp=50 --json")["simulated_participants"].is_null());
}

TEST_CASE("decid/power: a difference of a parameter that fits fix needs its --measurement-sd") {
  const std::string power =
      "power --model " DECID_SOURCE_DIR "/models/dec2015.safetensors --by fit --recordings 8 --difference Kp=-80";
  check_refused(power, "--difference");
  check_refused(power + " --difference delay=0.02", "--difference");
  // Only the other parameter's uncertainty is predicted.
  const Json found = run_json(power + " --measurement-sd Kp=60 --difference delay=0.02 --json --quiet");
  for (const Json& one : found["parameters"]) CHECK(one["measurement_sd"].get<double>() > 0.0);
}
