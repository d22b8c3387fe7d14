// Scans the XML of office programs: elements, attributes, text. Not installed.
// Format: XML 1.0 in UTF-8 without declarations of a document type, of which there are none in workbooks.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace decid::recording {

/// Goes through a text from tag to tag. Names are those behind a prefix: "row" of "x:row".
class XmlScanner {
 public:
  enum class Tag { open, close, end };

  /// `where` names the file and must outlive this, as the text must.
  XmlScanner(std::string_view text, const std::string& where) : rest_(text), where_(where) {}

  /// The next tag; an element without content opens, then closes. Throws Error for what is no XML.
  Tag next();
  std::string_view name() const { return name_; }
  /// An attribute of the tag that opened last; empty if there is none.
  std::string attribute(std::string_view name) const;
  /// The characters between the last tag and the one before.
  const std::string& text() const { return text_; }

 private:
  std::string decoded(std::string_view raw) const;
  std::string_view until(std::string_view mark);
  [[noreturn]] void refuse(const char* what) const;

  std::string_view rest_, name_, attributes_;
  std::string text_;
  bool closes_ = false;  ///< the element that was opened last has no content
  const std::string& where_;
};

}  // namespace decid::recording
