// Weights and heights in a study's sheet: names of their columns in several languages, units in names, cells and BIDS'
// sidecars.
#include <doctest/doctest.h>

#include "identify/study/sheet.hpp"
#include "identify/study/sidecar.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/study/sheet_files.hpp"

using namespace decid;
using namespace decid::test;

TEST_CASE("read_sheet: weights and heights in other languages, and with their unit in the cell") {
  const TemporaryFolder folder;
  for (const char* names :
       {"Patient\tFichier\tTaille (cm)\tPoids (kg)\tGroupe", "Paciente\tArchivo\tAltura [cm]\tPeso_kg\tGrupo",
        "Paziente\tFile\tAltezza\tPeso\tGruppo", "sujet\tfile\tlengte_cm\tgewicht\tgroup",
        "sujeto\tarchivo\ttalla\tpeso\tgrupo", "soggetto\tfile\tstature\tpoids\tgruppo"}) {
    CAPTURE(names);
    const SheetLine line =
        read_sheet(write_text(folder / "l.tsv", std::string(names) + "\nA\ta.csv\t170\t70,5\tx\n")).lines.at(0);
    CHECK(line.entry == SheetEntry{"A", "", "x", "", {}});
    CHECK(line.file == "a.csv");
    CHECK(line.height_m == 1.7);
    CHECK(line.mass_kg == 70.5);
  }
  const StudySheet cells = read_sheet(write_text(folder / "c.tsv",
                                                 "ID\theight\tweight\nA\t1,75 m\t70 kg\nB\t69 in\t154lbs\n"
                                                 "C\t175cm\t70.0 kg\nD\t5 ft 9\tn/a\nE\tn/a\t11 stone\n"));
  REQUIRE(cells.lines.size() == 5);
  for (const std::size_t i : {std::size_t{0}, std::size_t{2}}) {
    CHECK(cells.lines[i].height_m == 1.75);
    CHECK(cells.lines[i].mass_kg == 70.0);
  }
  CHECK(near(cells.lines[1].height_m.value(), 69 * 0.0254, 1e-15));
  CHECK(near(cells.lines[1].mass_kg.value(), 154 * 0.45359237, 1e-15));
  check_has(cells.lines[3].error, Code::value_invalid, "line 5, height: '5 ft 9'");
  check_has(cells.lines[4].error, Code::value_invalid, "line 6, weight: '11 stone'");
  const StudySheet differs =
      read_sheet(write_text(folder / "d.tsv", "ID\theight\tweight_lb\nA\t175\t70 kg\nB\t175\t154 lb\n"));
  check_has(differs.lines.at(0).error, Code::value_invalid, "line 2, weight_lb: '70 kg'");
  CHECK(near(differs.lines.at(1).mass_kg.value(), 154 * 0.45359237, 1e-15));
}

TEST_CASE("read_sheet: a cell without a unit is an error if another cell of its column is not in kg, m or cm") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) { return read_sheet(write_text(folder / "u.csv", text)).lines; };
  const auto body = [&](const std::string& column, const std::string& one, const std::string& other) {
    return read("id;file;" + column + "\nA;a.csv;" + one + "\nB;b.csv;" + other + "\n");
  };
  const auto both = read(
      "participant_id;session;file;height;weight\nA;1;a.csv;69 in;154 lb\nA;2;b.csv;175;130\n"
      "B;1;c.csv;175 cm;70 kg\nC;1;d.csv;n/a;\n");
  CHECK_FALSE(both[0].error);
  check_has(both[1].error, Code::value_invalid, "line 3, height: '175' has no unit, and '69 in' in line 2 has one");
  CHECK_FALSE(both[1].mass_kg);
  CHECK_FALSE(both[2].error);
  CHECK(both[2].height_m == 1.75);
  CHECK(both[2].mass_kg == 70.0);
  CHECK_FALSE(both[3].error);
  for (const char* cell : {"154 lb", "154lbs", "154 (pounds)", "11 stone", "11st 4", "70000 g", "700 N", "154 lb?"}) {
    CAPTURE(cell);
    check_has(body("weight", cell, "130")[1].error, Code::value_invalid, "give one unit, in the name or in all cells");
    check_has(body("weight", "130", cell)[0].error, Code::value_invalid, "line 2, weight: '130' has no unit");
  }
  for (const char* cell : {"69 in", "5 ft 9", "5ft", "5'9", "1750 mm", "69\u2033", "69 Zoll"}) {
    CAPTURE(cell);
    check_has(body("height", cell, "175")[1].error, Code::value_invalid, "line 3, height: '175' has no unit");
  }
  // A unit of the name is the cells' without one, and kg, m and cm are those of a name without one.
  const auto named = body("weight_lb", "154 lb", "154");
  CHECK(named[0].mass_kg == named[1].mass_kg);
  CHECK(near(named[1].mass_kg.value(), 154 * 0.45359237, 1e-15));
  CHECK(body("weight", "70 kg", "70")[1].mass_kg == 70.0);
  for (const char* cell : {"1.75 m", "175 cm", "175 (cm)"}) CHECK(body("height", cell, "175")[1].height_m == 1.75);
  for (const char* cell : {"n/a", "-", "x", "70 kg", "70 left"}) CHECK(body("weight", cell, "70")[1].mass_kg == 70.0);
  // So is the sidecar's.
  write_text(folder / "participants.json", R"({"weight": {"Units": "lb"}})");
  const SheetLine sidecar =
      read_sheet(write_text(folder / "participants.tsv", "participant_id\tweight\nA\t154 lb\nB\t154\n")).lines.at(1);
  CHECK(sidecar.mass_kg == named[1].mass_kg);
}

TEST_CASE("read_sheet: a unit in a cell is taken as it is written, and the body must be possible") {
  const TemporaryFolder folder;
  const auto line = [&](const std::string& column, const std::string& cell) {
    return read_sheet(write_text(folder / "b.tsv", "id\t" + column + "\nA\t" + cell + "\n")).lines.at(0);
  };
  for (const char* cell : {"60 kg", "60kg", "60 Kg.", "60 (kg)", "60 [KG]", "60,0 kg"}) {
    CAPTURE(cell);
    CHECK(line("weight", cell).mass_kg == 60.0);
  }
  for (const char* cell : {"60?kg", "60 kg?", "60/kg", "60 kg, 70", "60 'kg'", "0.06 kg", "600 kg", "60 cm", "60 ()"}) {
    CAPTURE(cell);
    check_has(line("weight", cell).error, Code::value_invalid, "line 2, weight: '" + std::string(cell) + "'");
    CHECK_FALSE(line("weight", cell).mass_kg);
  }
  for (const char* cell : {"1.7 m", "1,70m", "170 cm", "170 cm.", "170.0 (cm)"})
    for (const char* column : {"height", "height_m", "height_cm"}) {
      CAPTURE(cell);
      CHECK(line(column, cell).height_m == 1.7);
    }
  for (const char* cell : {"1.75 cm", "175 m", "175?cm", "29 cm", "301 cm", "3.1 m"})
    for (const char* column : {"height", "height_m", "height_cm"}) {
      CAPTURE(cell);
      check_has(line(column, cell).error, Code::value_invalid, ": '" + std::string(cell) + "' is neither");
    }
  check_has(line("height_cm", "1700 mm").error, Code::value_invalid, "another unit than the column's name");
  CHECK(near(line("height", "1700 mm").height_m.value(), 1.7, 1e-15));
}

TEST_CASE("read_sheet: names of other languages are carried along beside surer ones, and have units joined by words") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) { return read_sheet(write_text(folder / "f.csv", text)); };
  using Columns = std::vector<std::string>;
  const StudySheet waist = read("ID;Datei;Gr\u00f6\u00dfe;Gewicht;Taille (cm)\nA;a.csv;175;70;85\n");
  CHECK(waist.columns == Columns{"Taille (cm)"});
  CHECK(waist.lines[0].height_m == 1.75);
  CHECK(waist.lines[0].entry.cells == Columns{"85"});
  const StudySheet clothes = read("id;talla;height;stature;weight;poids\nA;42;175;small;70;x\n");
  CHECK(clothes.columns == Columns{"talla", "stature", "poids"});
  CHECK(clothes.lines[0].height_m == 1.75);
  CHECK(clothes.lines[0].mass_kg == 70.0);
  CHECK_FALSE(clothes.lines[0].error);
  const StudySheet people = read("sujet;id;groupe;group;archivo;file\nx;A;y;old;z;a.csv\n");
  CHECK(people.columns == Columns{"sujet", "groupe", "archivo"});
  CHECK(people.lines[0].entry == SheetEntry{"A", "", "old", "", {"x", "y", "z"}});
  CHECK(people.lines[0].file == "a.csv");
  CHECK((people.participant_column == "id" && people.group_column == "group"));
  CHECK(people.reader_for("Groupe")(people.lines[0].entry) == "y");
  CHECK(read("sujet;code\nx;A\n").lines[0].entry.participant == "A");
  CHECK(read("sujet;groupe\nx;A\n").group_column == "groupe");
  // In German and Dutch, Taille is the waist also without a height.
  CHECK_FALSE(read("ID;Gewicht;Taille (cm)\nA;70;85\n").lines[0].height_m);
  check_error([&] { read("id;taille;estatura\nA;175;175\n"); }, Code::column_ambiguous);
  check_error([&] { read("id;height;Gr\u00f6\u00dfe\nA;175;175\n"); }, Code::column_ambiguous);
  for (const char* names : {"Taille en cm;Poids en kg", "Altura em cm;Peso em kg", "Talla (cm);Peso corporal",
                            "taille;Poids corporel (kg)", "Estatura;peso corporal en kg", "lengte in m;Gewicht"}) {
    CAPTURE(names);
    const SheetLine line = read("id;" + std::string(names) + "\nA;170;70,5\n").lines.at(0);
    CHECK(line.height_m == 1.7);
    CHECK(line.mass_kg == 70.5);
  }
  const auto pounds = read("id;Peso en lb\nA;154\n").lines.at(0).mass_kg;
  CHECK(near(pounds.value(), 154 * 0.45359237, 1e-15));
}

TEST_CASE("read_sheet: a column in kg is noted if the sheet has no weight") {
  const TemporaryFolder folder;
  const auto notes = [&](const std::string& names) {
    return read_sheet(write_text(folder / "n.tsv", "ID\tfile\t" + names + "\nA\ta.csv\t70\t170\n")).notes;
  };
  REQUIRE(notes("Vikt (kg)\theight").size() == 1);
  CHECK(contains(notes("vaha_kg\theight").front(), "vaha_kg is carried along"));
  CHECK(notes("weight\tlean mass [kg]").empty());
  REQUIRE(notes("kg\tcm").size() == 1);
  CHECK(contains(notes("kg\tcm").front(), "column kg is carried along"));
  for (const char* per_mass : {"torque (Nm/kg)", "VO2 [ml/min/kg]", "power W / kg", "Nm/(kg)", "Rang"}) {
    CAPTURE(per_mass);
    CHECK(notes(std::string(per_mass) + "\tcm").empty());
  }
}

TEST_CASE("read_sheet: a sidecar of BIDS gives the units of weights and heights whose names have none") {
  const TemporaryFolder folder;
  const auto path = write_text(folder / "participants.tsv", "participant_id\tweight\theight\tage\nA\t154\t70\t60\n");
  const auto with = [&](const std::string& sidecar) {
    write_text(folder / "participants.json", sidecar);
    return read_sheet(path).lines.at(0);
  };
  CHECK(sidecar_of(path) == std::nullopt);
  const SheetLine found =
      with(R"({"weight": {"Units": "lb"}, "height": {"Description": "h", "Units": "[in_i]"}, "age": {"Units": "x"}})");
  CHECK(near(found.mass_kg.value(), 154 * 0.45359237, 1e-15));
  CHECK(near(found.height_m.value(), 70 * 0.0254, 1e-15));
  CHECK(sidecar_of(path) == folder / "participants.json");
  CHECK(with(R"({"weight": {"Units": "kg"}, "height": 5})").mass_kg == 154.0);
  check_error([&] { with(R"({"weight": {"Units": "stone"}})"); }, Code::unit_unknown, "\"stone\"");
  check_error([&] { with("{"); }, Code::setting_malformed, "participants.json");
  // A unit in the name counts, and so does only the sidecar of a sheet that BIDS names.
  write_text(folder / "participants.json", R"({"weight_kg": {"Units": "stone"}})");
  write_text(path, "participant_id\tweight_kg\nA\t70\n");
  CHECK(read_sheet(path).lines.at(0).mass_kg == 70.0);
  write_text(folder / "people.json", R"({"weight": {"Units": "stone"}})");
  CHECK(read_sheet(write_text(folder / "people.tsv", "ID\tweight\nA\t70\n")).lines.at(0).mass_kg == 70.0);
  CHECK(sidecar_of(folder / "people.tsv") == std::nullopt);
}
