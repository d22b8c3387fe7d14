// Files, folders and patterns that name recordings.
#include "tools/decid/recording_files.hpp"

#include "base/error.hpp"
#include "identify/study/find_recordings.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using decid::tools::LeftOut;
using Names = std::vector<std::string>;

namespace {

Names recording_files(const Names& arguments, const Names& others = {}, bool recursive = false) {
  return decid::tools::recording_files(arguments, others, recursive).files;
}

LeftOut left_out(const std::string& argument, bool recursive = false, const Names& others = {}) {
  return decid::tools::recording_files({argument}, others, recursive).left_out;
}

std::string refusal(const std::string& argument, const Names& others = {}) {
  return name(error_of([&] { recording_files({argument}, others); }).code());
}

}  // namespace

TEST_CASE("a folder stands for the recordings in it, in the order of their names") {
  const Folder folder;
  for (const char* name : {"b.csv", "a.MAT", "b.C3D", "c.txt", "notes.docx", ".hidden.csv", "README", "d.tsv", "e.dat"})
    write_text(folder / name, "");
  std::filesystem::create_directory(folder / "within.csv");
  const std::string path = folder / "";
  CHECK(recording_files({path}) == Names{folder / "a.MAT", folder / "b.C3D", folder / "b.csv", folder / "c.txt",
                                         folder / "d.tsv", folder / "e.dat"});
  CHECK(recording_files({"first.csv", path, folder / "b.csv"}, {folder / "c.txt", "", folder / "./e.dat"}) ==
        Names{"first.csv", folder / "a.MAT", folder / "b.C3D", folder / "b.csv", folder / "d.tsv", folder / "b.csv"});
  CHECK(refusal(folder / "within.csv") == "file_missing");
}

TEST_CASE("a pattern gives its matches, unless a file has exactly that name") {
  const Folder folder;
  for (const char* name : {"s2.csv", "s1.csv", "s10.csv", "t1.csv", "s[1].csv"}) write_text(folder / name, "");
  std::filesystem::create_directory(folder / "sub");
  write_text(folder / "sub/x.csv", "");
  CHECK(recording_files({folder / "s?.csv"}, {}) == Names{folder / "s1.csv", folder / "s2.csv"});
  CHECK(recording_files({folder / "[st]1.csv"}, {}) == Names{folder / "s1.csv", folder / "t1.csv"});
  CHECK(recording_files({folder / "s[1].csv"}, {}) == Names{folder / "s[1].csv"});
  CHECK(recording_files({folder / "su*"}, {}) == Names{folder / "sub/x.csv"});
  CHECK(recording_files({folder / "s?.csv"}, {folder / "s1.csv"}) == Names{folder / "s2.csv"});
  CHECK(refusal(folder / "u*.csv") == "file_missing");
  CHECK(refusal(folder / "t*", {folder / "t1.csv"}) == "file_missing");
}

TEST_CASE("folders within are read where asked for, and by ** in a pattern") {
  const Folder folder;
  for (const char* name : {"in/s1/day1", "in/s2", "in/.cache"}) std::filesystem::create_directories(folder / name);
  for (const char* name : {"in/a.csv", "in/s1/b.csv", "in/s1/day1/c.csv", "in/s1/day1/c.txt", "in/s2/d.csv",
                           "in/s2/d.pdf", "in/.cache/e.csv"})
    write_text(folder / name, "");
  CHECK(recording_files({folder / "in"}) == Names{folder / "in/a.csv"});
  CHECK(left_out(folder / "in").folders == 2);
  CHECK(recording_files({folder / "in"}, {}, true) == Names{folder / "in/a.csv", folder / "in/s1/b.csv",
                                                            folder / "in/s1/day1/c.csv", folder / "in/s1/day1/c.txt",
                                                            folder / "in/s2/d.csv"});
  CHECK(left_out(folder / "in", true).folders == 0);
  CHECK(left_out(folder / "in", true).endings == std::set<std::string>{".pdf"});
  CHECK(recording_files({folder / "in/**/*.csv"}) ==
        Names{folder / "in/a.csv", folder / "in/s1/b.csv", folder / "in/s1/day1/c.csv", folder / "in/s2/d.csv"});
  CHECK(recording_files({folder / "in/**/day?/*.csv"}) == Names{folder / "in/s1/day1/c.csv"});
  CHECK(recording_files({folder / "in/s*/**"}) == Names{folder / "in/s1/b.csv", folder / "in/s1/day1/c.csv",
                                                        folder / "in/s1/day1/c.txt", folder / "in/s2/d.csv"});
  CHECK(recording_files({folder / "in/**/d.pdf"}) == Names{folder / "in/s2/d.pdf"});  // the pattern names it
  CHECK(recording_files({folder / "in/s?"}, {}, true).size() == 4);
  CHECK(refusal(folder / "in/**/z.csv") == "file_missing");
  CHECK(refusal(folder / "none/**") == "file_missing");
}

TEST_CASE("decid's own tables are no recordings of the next call") {
  const Folder folder;
  std::filesystem::create_directory(folder / "in");
  write_text(folder / "in/a.csv", "time,sway_deg\n0,1\n");
  const std::string call =
      "identify --quiet " + folder / "in/a.csv" + " --table " + folder / "in/t.csv" + " --long " + folder / "in/l.csv";
  for (const char* excel : {"", " --excel comma"}) {
    run_decid(call + excel);  // a recording with an error has a line too
    REQUIRE(std::filesystem::exists(folder / "in/l.csv"));
    CHECK(recording_files({folder / "in"}) == Names{folder / "in/a.csv"});
    CHECK(left_out(folder / "in").results == 2);
    CHECK(decid::recordings_below(folder / "in").size() == 1);
  }
  CHECK(recording_files({folder / "in/t.csv"}) == Names{folder / "in/t.csv"});  // named, it is what the user wants
}

TEST_CASE("decid's own workbook, draws and figures are no recordings of the next call") {
  const Folder folder;
  std::filesystem::create_directory(folder / "in");
  write_text(folder / "in/a.csv", "time,sway_deg\n0,1\n");
  run_decid("identify --quiet " + folder / "in/a.csv" + " --table " + folder / "in/t.xlsx" + " --long " +
            folder / "in/l.xlsx");
  REQUIRE(std::filesystem::exists(folder / "in/l.xlsx"));
  const char* const figures[] = {"parameter,unit,participant_id,session,group,condition,file,value,low90,high90,mgh\n",
                                 "parameter,unit,participant_id,group,session,value,mgh\n",
                                 "participant_id,session,group,condition,file,frequency_hz,gain,phase_deg\n",
                                 ".chain,.iteration,.draw,lp__\n", "file,.chain,.iteration,.draw,lp__\n"};
  for (std::size_t i = 0; i < std::size(figures); ++i)
    write_text(folder / ("in/f" + std::to_string(i) + ".csv"), figures[i]);
  CHECK(recording_files({folder / "in"}) == Names{folder / "in/a.csv"});
  CHECK(left_out(folder / "in").results == 7);
}

TEST_CASE("an output that would overwrite a recording of a folder, a pattern or a sheet is refused") {
  const Folder folder;
  std::filesystem::create_directory(folder / "in");
  const std::string content = "time,sway_deg\n0,1\n";
  for (const char* name : {"in/a.csv", "in/b.csv"}) write_text(folder / name, content);
  write_text(folder / "in/participants.tsv", "participant_id\tfile\n1\ta.csv\n2\tb.csv\n");
  const std::string output = folder / "in/b.csv";
  const std::string by_folder = folder / "in", by_pattern = "'" + folder / "in/*.csv" + "'",
                    by_sheet = "--study " + folder / "in/participants.tsv";
  for (const std::string& call :
       {"identify " + by_folder + " --table " + output, "identify " + by_pattern + " --long " + output,
        "identify " + by_sheet + " --table " + output, "identify " + by_folder + " " + by_sheet + " --table " + output,
        "fit " + by_folder + " --draws " + output}) {
    const auto refused = run_decid(call);
    CAPTURE(call);
    CAPTURE(refused.err);
    CHECK(refused.code == 2);
    CHECK(contains(refused.err, output + ": is already read or written by this call"));
    CHECK(read_text(output) == content);
  }
  // A table of the call before is overwritten, and so is a file of another kind that a pattern matches.
  for (int run = 0; run < 2; ++run) {
    const auto made = run_decid("identify --json '" + folder / "in/*" + "' --table " + folder / "in/t.csv" + " -o " +
                                folder / "in/r.json");
    CAPTURE(made.err);
    CHECK(std::filesystem::exists(folder / "in/r.json"));
    CHECK(!contains(made.err, "is already read"));
  }
}

TEST_CASE("files left out of folders and patterns are counted") {
  const Folder folder;
  std::filesystem::create_directory(folder / "in");
  for (const char* name : {"in/a.csv", "in/participants.tsv", "in/README.txt", "in/readme.csv", "in/s1_channels.tsv",
                           "in/LICENSE", "in/x.pdf", "in/y.pdf", "in/z.json", "in/.hidden.csv", "in/out.html"})
    write_text(folder / name, "");
  std::filesystem::create_symlink("nowhere.csv", folder / "in/dead.csv");
  std::filesystem::create_symlink("a.csv", folder / "in/link.csv");
  const LeftOut found = left_out(folder / "in", false, {folder / "in/out.html"});
  CHECK(recording_files({folder / "in"}) == Names{folder / "in/a.csv", folder / "in/link.csv"});
  CHECK(found.dead_links == 1);
  CHECK(found.descriptions == 5);
  CHECK(found.other_endings == 3);
  CHECK(found.folders == 0);
  CHECK(found.text() ==
        "left out: 1 dead link, 3 files of other kinds (.json, .pdf), 5 descriptions (participants.tsv, README and the "
        "like)");
  CHECK(LeftOut().text().empty());
  CHECK(recording_files({folder / "in/*.csv"}) == Names{folder / "in/a.csv", folder / "in/link.csv"});
  CHECK(left_out(folder / "in/*.csv").dead_links == 1);
  CHECK(refusal(folder / "in/p*.tsv") == "file_missing");
  CHECK(recording_files({folder / "in/participants.tsv"}) == Names{folder / "in/participants.tsv"});  // named itself
}

TEST_CASE("a folder that cannot be read is an error" * doctest::skip(::geteuid() == 0)) {
  const Folder folder;
  std::filesystem::create_directory(folder / "closed");
  std::filesystem::permissions(folder / "closed", std::filesystem::perms::none);
  CHECK(refusal(folder / "closed") == "file_unreadable");
  std::filesystem::permissions(folder / "closed", std::filesystem::perms::owner_all);
}

TEST_CASE("a MAT-file of version 7.3 where matio cannot be loaded: a clear line, and other files are read") {
  const Folder folder;
  write_text(folder / "libmatio.so.11", "");  // found first, and no library
  const std::string without = "LD_LIBRARY_PATH=" + folder / "" + " ";
  const std::string mat = std::string(DECID_SOURCE_DIR) + "/tests/recording/mat/";
  const auto refused = run_decid("identify " + mat + "v73_h5py.mat", without);
  CAPTURE(refused.err);
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK(contains(refused.err, "need matio, which cannot be loaded: "));
  CHECK(contains(refused.err, "; install it (Debian: libmatio11), or save the file with '-v7', or as CSV\n"));
  CHECK(contains(run_decid("identify " + mat + "v5.mat", without).err, "recording has 20 samples at 50 Hz"));
}
