// Paths of recordings compared: see path_match.hpp.
#include "identify/study/detail/path_match.hpp"

#include <algorithm>
#include <sstream>
#include <string_view>

#include "identify/study/detail/text_key.hpp"
#include "identify/study/find_recordings.hpp"

namespace decid {
namespace {

std::vector<std::string> parts_of(std::string path) {
  std::ranges::replace(path, '\\', '/');
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string part = path.substr(begin, end - begin);
    if (part == ".." && !parts.empty()) parts.pop_back();
    if (!part.empty() && part != "." && part != "..") parts.push_back(part);
    begin = end + 1;
  }
  return parts;
}

/// Returns a file's name without the ending of a recording. A part of a file ("long.csv#2") keeps its number.
std::string without_ending(const std::string& name) {
  const std::size_t hash = std::min(name.rfind('#'), name.size());
  const std::string file = name.substr(0, hash), number = name.substr(hash);
  for (const std::string_view ending : endings_of_recordings)
    if (file.size() > ending.size() && file.ends_with(ending))
      return file.substr(0, file.size() - ending.size()) + number;
  return name;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Letters of other alphabets are bytes above 127.
bool is_of_a_word(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || static_cast<unsigned char>(c) >= 0x80;
}

/// Returns true if `text` has `word` with no letter or digit next to it, and none of `beyond` behind it.
bool has_word(const std::string& text, const std::string& word, std::string_view beyond = {}) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    const bool ends = end == text.size() || (!is_of_a_word(text[end]) && beyond.find(text[end]) == beyond.npos);
    if (ends && (at == 0 || !is_of_a_word(text[at - 1]))) return true;
  }
  return false;
}

bool same_end(const std::vector<std::string>& path, const std::vector<std::string>& end) {
  return !end.empty() && end.size() <= path.size() && std::equal(end.rbegin(), end.rend(), path.rbegin());
}

}  // namespace

PathKey::PathKey(const std::string& path) : exact_(parts_of(path)) {
  for (const std::string& part : exact_) forgiving_.push_back(text_key(part));
  if (!forgiving_.empty()) stem_ = without_ending(forgiving_.back());
}

PathKey::Likeness PathKey::ends_with(const PathKey& end) const {
  if (same_end(exact_, end.exact_)) return Likeness::exact;
  if (same_end(forgiving_, end.forgiving_)) return Likeness::forgiving;
  if (end.forgiving_.empty() || stem_ != end.stem_) return Likeness::none;
  const std::vector<std::string> folders(forgiving_.begin(), forgiving_.end() - 1),
      end_folders(end.forgiving_.begin(), end.forgiving_.end() - 1);
  return end_folders.empty() || same_end(folders, end_folders) ? Likeness::without_ending : Likeness::none;
}

std::vector<std::string> PathKey::session_labels() const {
  constexpr std::string_view prefix = "ses-";
  std::vector<std::string> labels;
  const auto add = [&](const std::string& entity) {
    if (!text_key(entity).starts_with(prefix)) return;
    const std::string label = entity.substr(prefix.size(), entity.find('#') - prefix.size());
    const auto is_same = [&](const std::string& other) { return text_key(other) == text_key(label); };
    if (!label.empty() && std::ranges::none_of(labels, is_same)) labels.push_back(label);
  };
  bool is_below_participant = false;
  for (std::size_t i = 0; i + 1 < exact_.size(); ++i) {
    if (is_below_participant) add(exact_[i]);
    is_below_participant = is_below_participant || forgiving_[i].starts_with("sub-");
  }
  if (exact_.empty()) return labels;
  std::istringstream entities(without_ending(exact_.back()));
  for (std::string entity; std::getline(entities, entity, '_');) add(entity);
  return labels;
}

PathKey::Naming PathKey::naming_of_session(const std::string& session, const std::string& participant) const {
  if (naming_of_participant(participant) == Naming::prefixed) return naming_of(session, "ses-", parts());
  std::size_t own = 0;
  for (const std::string key = text_key(participant); own < parts() && part(own) != key;) ++own;
  return naming_of(session, "ses-", own);
}

const std::string& PathKey::part(std::size_t i) const {
  return i + 1 == forgiving_.size() ? stem_ : forgiving_[i];
}

/// except: the part that is left out.
PathKey::Naming PathKey::naming_of(const std::string& wanted, const std::string& prefix, std::size_t except) const {
  const std::string key = text_key(wanted);
  if (key.empty()) return Naming::none;
  const std::string with_prefix = key.starts_with(prefix) ? key : prefix + key;
  const bool is_number = std::ranges::all_of(key, is_digit);
  Naming found = Naming::none;
  for (std::size_t i = 0; i < forgiving_.size(); ++i) {
    if (i == except) continue;
    const bool is_file = i + 1 == forgiving_.size();
    const std::string& text = part(i);
    if (has_word(text, with_prefix, "-")) return Naming::prefixed;  // not "sub-01" in "sub-01-b"
    if (!is_file && text == key) found = Naming::folder;
    if (text == key || has_word(text, with_prefix) || (!is_number && has_word(text, key)))
      found = std::max(found, Naming::within);
  }
  return found;
}

}  // namespace decid
