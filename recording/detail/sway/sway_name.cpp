// Names of columns of sway: see sway_name.hpp.
#include "recording/detail/sway/sway_name.hpp"

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

/// Returns true if the name has one of the words, also after the letter of a side: "lankle", "RKNEE".
bool has_word(std::string_view name, std::initializer_list<std::string_view> list) {
  return std::ranges::any_of(words_in(name), [&](std::string_view word) {
    const bool may_have_side = word.size() > 3 && (word.front() == 'l' || word.front() == 'r');
    return one_of(word, list) || (may_have_side && one_of(word.substr(1), list));
  });
}

/// Words of names and labels of markers (Plug-in Gait's among them), with the part of the body. Vertebrae between T10
/// and the sacrum are missing: they are near the centre of mass.
struct PartWord {
  std::string_view word;
  const char* part;
};
constexpr PartWord part_words[] = {
    {"head", "head"},         {"kopf", "head"},       {"fhd", "head"},          {"bhd", "head"},
    {"neck", "neck"},         {"nacken", "neck"},     {"c7", "neck"},           {"shoulder", "shoulder"},
    {"schulter", "shoulder"}, {"sho", "shoulder"},    {"acromion", "shoulder"}, {"akromion", "shoulder"},
    {"acr", "shoulder"},      {"trunk", "trunk"},     {"rumpf", "trunk"},       {"thorax", "trunk"},
    {"chest", "trunk"},       {"brust", "trunk"},     {"sternum", "trunk"},     {"strn", "trunk"},
    {"clavicle", "trunk"},    {"clavicula", "trunk"}, {"clav", "trunk"},        {"scapula", "trunk"},
    {"spine", "spine"},       {"t8", "spine"},        {"t10", "spine"},         {"th10", "spine"},
    {"foot", "foot"},         {"fuss", "foot"},       {"fu\xC3\x9F", "foot"},   {"knee", "knee"},
    {"knie", "knee"},         {"thigh", "thigh"},     {"pelvis", "pelvis"},     {"hip", "hip"},
};

/// Returns true for a place on the body, a marker, a centre or a direction: the name says where, and not what.
bool names_place(std::string_view word) {
  if (word.starts_with("marker")) return word.find_first_not_of("0123456789", 6) == word.npos;
  const bool may_have_side = word.size() > 3 && (word.front() == 'l' || word.front() == 'r');
  const auto is_place = [](std::string_view text) {
    return one_of(text, {"com",    "cog",    "cm",   "xcom",       "xcog",       "comap", "cogap",    "waist", "taille",
                         "sacrum", "sacral", "sacr", "l1",         "l2",         "l3",    "l4",       "l5",    "s1",
                         "s2",     "hip",    "hips", "h\u00FCfte", "huefte",     "asis",  "psis",     "asi",   "psi",
                         "lasi",   "rasi",   "lpsi", "rpsi",       "trochanter", "navel", "umbilicus"});
  };
  return is_place(word) || (may_have_side && is_place(word.substr(1)));
}

/// Returns true for a direction, a side or a number behind a place.
bool names_direction(std::string_view word) {
  return one_of(word, {"ap", "antpost", "ant", "post", "anterior", "posterior", "anteroposterior", "sagittal", "l", "r",
                       "left", "right", "links", "rechts", "raw", "filtered", "filt"}) ||
         word.find_first_not_of("0123456789") == word.npos;
}

/// Returns true for "CoM", "CoM (ant-post)", "AP", "L5" and "marker 1".
bool is_bare_place(const std::vector<std::string>& parts) {
  const bool is_direction = parts.size() == 1 && one_of(parts[0], {"ap", "antpost", "anteroposterior"});
  return is_direction ||
         (std::ranges::any_of(parts, names_place) && std::ranges::all_of(parts, [](const std::string& part) {
            return names_place(part) || names_direction(part);
          }));
}

/// Returns true for instruments and words of distances: a sway rod, a string potentiometer, an excursion.
bool names_distance(const std::vector<std::string>& parts) {
  const auto has = [&](std::string_view word) { return std::ranges::find(parts, word) != parts.end(); };
  const auto has_start = [&](std::string_view start) {
    return std::ranges::any_of(parts, [&](const std::string& part) { return part.starts_with(start); });
  };
  return has("rod") || has("swayrod") || has("excursion") || has("excursions") || has("lvdt") || has("seilzug") ||
         has_start("stringpot") || has_start("drawwire") || (has("string") && has_start("pot")) ||
         (has("draw") && has("wire"));
}

}  // namespace

bool is_ankle_name(std::string_view name) {
  return has_word(name, {"ankle", "sprunggelenk", "sprunggelenkswinkel", "sprunggelenkwinkel", "osg", "dorsiflexion",
                         "plantarflexion"});
}

bool is_body_name(std::string_view name) {
  return has_word(name, {"com", "cog", "sway", "bodysway", "body", "lean", "leg", "bein", "ksp", "schwankung"}) ||
         std::ranges::any_of(part_words, [&](const PartWord& part) { return has_word(name, {part.word}); });
}

void refuse_ankle(const std::string& name, const std::string& where) {
  if (other_quantity(name) != nullptr) return;              // another error names that quantity
  for (const char* whole : {"com", "cog", "sway", "body"})  // such as "com_sway about the ankle", "CoMAnkleAngle"
    if (words(name).front().starts_with(whole)) return;
  if (!is_ankle_name(name)) return;
  throw Error(Code::column_unsuitable, where,
              name + " is an ankle angle by its name: relative to the platform, not in space",
              "add the platform's tilt, and name the sum sway");
}

void warn_of_part(const std::string& name, Recording& recording) {
  std::string_view warned;
  for (const auto& [word, part] : part_words) {
    // A hip marker may stand for the centre of mass, a hip joint's angle may not.
    if (part == warned || !has_word(name, {word}) || (word == "hip" && !has_word(name, {"angle", "angles", "flexion"})))
      continue;
    add_caution(
        recording.warnings, "sway_of_a_part",
        name + " belongs to the " + part + " by its name; the model needs the sway of the body's centre of mass");
    warned = part;
  }
  for (const char* other : {"ml", "lateral", "mediolateral", "yaw", "heading", "gaze", "eye", "target", "setpoint"})
    if (has_word(name, {other}))
      add_caution(recording.warnings, "not_this_sway",
                  name + " is '" + other + "' by its name; the model needs the forward sway");
}

bool is_position_name(const std::string& name) {
  if (has_word(name, {"angle", "angles", "angular", "winkel", "rotation", "rot", "orientation", "euler", "pitch",
                      "roll", "yaw", "tilt", "lean", "inclination", "neigung", "flexion"}))
    return false;
  if (has_word(name, {"displacement", "displacements", "position", "positions", "pos", "trajectory", "comx", "comy",
                      "comz", "cogx", "cogy", "cogz", "tx", "ty", "tz"}))  // NDI's tools
    return true;
  const std::vector<std::string> parts = words(name);
  if (names_distance(parts) || is_bare_place(parts)) return true;
  if (parts.front() == "sway" || parts.front() == "body") return false;
  const bool is_centre = one_of(parts.front(), {"com", "cog"});
  return std::any_of(parts.begin() + 1, parts.end(), [&](const std::string& part) {
    return one_of(part, {"x", "y", "z"}) || (is_centre && one_of(part, {"ap", "ml"}));
  });
}

char axis_of(const std::string& name) {
  std::vector<std::string> parts = words(name);
  if (one_of(parts.back(), {"mm", "cm", "m"})) parts.pop_back();
  const bool is_axis = parts.size() > 1 && one_of(parts.back(), {"x", "y", "z"});
  return is_axis ? parts.back().front() : '\0';
}

}  // namespace decid::recording
