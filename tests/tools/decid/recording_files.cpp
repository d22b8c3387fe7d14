// Files, folders and patterns that name recordings.
#include "tools/decid/recording_files.hpp"

#include <doctest/doctest.h>

#include "base/error.hpp"
#include "tests/tools/decid/run.hpp"

using decid::test::Folder;
using decid::test::run_decid;
using decid::test::write_text;
using decid::tools::recording_files;
using Names = std::vector<std::string>;

namespace {

std::string refusal(const std::string& argument, const Names& others = {}) {
  try {
    recording_files({argument}, others);
  } catch (const decid::Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a folder stands for the recordings in it, in the order of their names") {
  const Folder folder;
  for (const char* name : {"b.csv", "a.MAT", "b.C3D", "c.txt", "notes.docx", ".hidden.csv", "README", "d.tsv", "e.dat"})
    write_text(folder / name, "");
  std::filesystem::create_directory(folder / "within.csv");
  const std::string path = folder / "";
  CHECK(recording_files({path}, {}) == Names{folder / "a.MAT", folder / "b.C3D", folder / "b.csv", folder / "c.txt",
                                             folder / "d.tsv", folder / "e.dat"});
  CHECK(recording_files({"first.csv", path, folder / "b.csv"}, {folder / "c.txt", "", folder / "./e.dat"}) ==
        Names{"first.csv", folder / "a.MAT", folder / "b.C3D", folder / "b.csv", folder / "d.tsv", folder / "b.csv"});
  CHECK(refusal(folder / "within.csv").find("within.csv: is a folder without a recording") != std::string::npos);
}

TEST_CASE("a pattern stands for what it matches, unless a file has that very name") {
  const Folder folder;
  for (const char* name : {"s2.csv", "s1.csv", "s10.csv", "t1.csv", "s[1].csv"}) write_text(folder / name, "");
  std::filesystem::create_directory(folder / "sub");
  write_text(folder / "sub/x.csv", "");
  CHECK(recording_files({folder / "s?.csv"}, {}) == Names{folder / "s1.csv", folder / "s2.csv"});
  CHECK(recording_files({folder / "[st]1.csv"}, {}) == Names{folder / "s1.csv", folder / "t1.csv"});
  CHECK(recording_files({folder / "s[1].csv"}, {}) == Names{folder / "s[1].csv"});
  CHECK(recording_files({folder / "su*"}, {}) == Names{folder / "sub/x.csv"});
  CHECK(recording_files({folder / "s?.csv"}, {folder / "s1.csv"}) == Names{folder / "s2.csv"});
  CHECK(refusal(folder / "u*.csv").find("u*.csv: matches no file") != std::string::npos);
  CHECK(refusal(folder / "t*", {folder / "t1.csv"}).find("matches no file") != std::string::npos);
}

TEST_CASE("what is neither stands for itself, whether it is there or not") {
  CHECK(recording_files({"none.csv", "/dev/stdin"}, {}) == Names{"none.csv", "/dev/stdin"});
}

TEST_CASE("a folder that cannot be read is an error" * doctest::skip(::geteuid() == 0)) {
  const Folder folder;
  std::filesystem::create_directory(folder / "closed");
  std::filesystem::permissions(folder / "closed", std::filesystem::perms::none);
  CHECK(refusal(folder / "closed").find("closed: cannot be read: Permission denied") != std::string::npos);
  std::filesystem::permissions(folder / "closed", std::filesystem::perms::owner_all);
}

TEST_CASE("a MAT-file of version 7.3 where matio cannot be loaded: a clear line, and other files are read") {
  const Folder folder;
  write_text(folder / "libmatio.so.11", "");  // found first, and no library
  const std::string without = "LD_LIBRARY_PATH=" + folder / "" + " ";
  const std::string mat = std::string(DECID_SOURCE_DIR) + "/tests/dataset/recording/mat/";
  const auto refused = run_decid("identify " + mat + "v73_h5py.mat", without);
  CAPTURE(refused.err);
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK(refused.err.find("need matio, which cannot be loaded: ") != std::string::npos);
  CHECK(refused.err.find("; install it (Debian: libmatio11), or save the file with '-v7', or as CSV\n") !=
        std::string::npos);
  CHECK(run_decid("identify " + mat + "v5.mat", without).err.find("recording has 20 samples at 50 Hz") !=
        std::string::npos);
}
