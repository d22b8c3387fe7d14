// decid export, as scripts call it: its outputs, names of files, and what it refuses.
#include <nlohmann/json.hpp>

#include "sim/segments.hpp"
#include "tests/tools/firmware/models.hpp"

namespace decid::tools {

using dataset::Channel;
using namespace test;

TEST_CASE("export c --json: sizes, and the body of the parameters") {
  const Folder folder;
  const std::string call = "export c " + test::firmware_model + " --name m --json -o " + folder / "c ";
  const auto own = run_json(call);
  CHECK(own["body"]["assumed"] == true);
  CHECK(own["body"]["mass_kg"] == sim::Body{}.mass_kg);
  CHECK(own["ood_score_bytes"] == 0);
  const auto told = run_json(call + "--ood-score --mass 60 --height 1.8");
  const sim::Body body = sim::make_body(sim::make_segments({.mass_kg = 60.0, .height_m = 1.8}));
  CHECK(told["body"]["assumed"] == false);
  CHECK(told["body"]["com_height_m"] == body.com_height_m);
  CHECK(told["body"]["inertia_kgm2"] == body.inertia_kgm2);
  CHECK(told["ood_score_bytes"] == 4 * (176 + 176 * 177 / 2));
}

TEST_CASE("export c: text output, and the default file name") {
  const Folder folder;
  const std::string odd = folder / "7 odd-name.safetensors";
  std::filesystem::copy_file(test::firmware_model, odd);
  const test::Result own = run_ok("export c '" + odd + "' -o " + folder / "c");
  CHECK(own.out.starts_with("model_7_odd_name.h and model_7_odd_name.c written to "));
  CHECK(contains(test::read_text(folder / "c/model_7_odd_name.c"), "from 7 odd-name.safetensors, weights SHA-256"));
  run_ok("export c '" + odd + "' --familiarity --mass 60 --height 1.8 --name m -o " + folder / "c");
  CHECK(contains(test::read_text(folder / "c/m.c"), "for a body of 60 kg and 1.8 m"));
  CHECK(run_ok("export c '" + odd + "' --int8 --quiet --name i -o " + folder / "c").out.empty());
  CHECK(contains(test::read_text(folder / "c/i.c"), ", in 8-bit integers."));
  std::filesystem::copy_file(test::firmware_model, folder / "time.safetensors");  // as a header of C is named
  run_ok("export c " + folder / "time.safetensors" + " --quiet -o " + folder / "c");
  CHECK(std::filesystem::exists(folder / "c/model_time.h"));
}

TEST_CASE("export does not replace a controller by a model, nor a model by a controller") {
  const Folder folder;
  const std::string model = "export c " + test::firmware_model + " --name balance --quiet -o " + folder / "c";
  const std::string controller = "export controller --name balance --quiet -o " + folder / "c";
  const auto refuses = [&](const std::string& arguments, const std::string& says) {
    const std::string header = test::read_text(folder / "c/balance.h"),
                      source = test::read_text(folder / "c/balance.c");
    check_refused(arguments, says);
    CHECK(test::read_text(folder / "c/balance.h") == header);
    CHECK(test::read_text(folder / "c/balance.c") == source);
  };
  run_ok(controller);
  run_ok(controller);
  refuses(model, "balance.h: is a controller, which a model would replace");
  std::filesystem::remove_all(folder / "c");
  run_ok(model);
  run_ok(model);
  refuses(controller, "balance.h: is a model, which a controller would replace");
  test::write_text(folder / "c/balance.h", "");
  refuses(controller, "balance.c: is a model, which a controller would replace");
}

TEST_CASE("decid evaluate --int8 measures the network in integers") {
  const Folder folder;
  run_ok("dataset --count 40 --seed 3 --quiet -o " + folder / "d.npz");
  const std::string call = "evaluate --json --model " + test::firmware_model + " --data " + folder / "d.npz";
  const auto mse = [](const test::Result& result) { return nlohmann::json::parse(result.out).at("mse").get<double>(); };
  CHECK(mse(run_ok(call + " --int8")) != mse(run_ok(call)));
}

TEST_CASE("bad input of decid export") {
  const Folder folder;
  const auto fails = [](const std::string& arguments, const std::string& says) {
    check_refused("export " + arguments, says);
  };
  const std::string model = test::firmware_model, out = " -o " + folder / "out";
  fails("c " + model + " -o /proc", "/proc");
  fails("c " + folder / "none" + out, "none: cannot be opened");
  test::write_text(folder / "file", "");
  fails("c " + folder / "file" + out, "file: is too short");
  fails("controller " + folder / "file" + out, "file: is not JSON");
  fails("controller --kp -1" + out, "Kp: is -1");
  fails("c " + model + " --name 'a b'" + out, "'a b' cannot begin");
  for (const char* name : {"stdint", "Math", "wctype"}) {
    fails("c " + model + " --name " + name + out, "is the name of a header of C");
    fails("controller --name " + std::string(name) + out, "is the name of a header of C");
  }
  fails("c " + model + " --int8 --ood-score" + out, "not of 8-bit integers");
  test::write_text(folder / "knows.safetensors",
                   to_bytes(test::made_up_model(sim::short_protocol(), {.window = 1000}, "fc 9; fc 7")));
  fails("c " + folder / "knows.safetensors" + " --ood-score" + out, "has no features of its training trials");
  // More layers than a byte can number.
  std::string deep = "conv 1 1x1";
  for (int i = 0; i < 260; ++i) deep += "; conv 1 1x1";
  test::write_text(folder / "deep.safetensors",
                   to_bytes(test::made_up_model(sim::short_protocol(), {.window = 1000}, deep + "; fc 7")));
  fails("c " + folder / "deep.safetensors" + out, "layers");
  // 11 x 110 x 110 inputs of one sum.
  const dataset::ImageSettings wide{.channels = std::vector<Channel>(11, Channel::modulus)};
  test::write_text(folder / "wide.safetensors", to_bytes(test::made_up_model(sim::default_protocol(), wide, "fc 7")));
  fails("c --int8 " + folder / "wide.safetensors" + out, "32 bits");
  // The last value of the last tensor becomes infinite.
  std::string infinite = to_bytes(test::made_up_model(sim::short_protocol(), {.window = 1000}, "fc 7"));
  infinite.replace(infinite.size() - 4, 4, std::string("\0\0\x80\x7f", 4));
  test::write_text(folder / "infinite.safetensors", infinite);
  fails("c " + folder / "infinite.safetensors" + out, "");
  CHECK(!std::filesystem::exists(folder / "out"));
  test::write_text(folder / "r.json", R"({"recordings": [{"file": "x", "error": "y"}]})");
  fails("controller " + folder / "r.json" + out, "recording 1");
}

}  // namespace decid::tools
