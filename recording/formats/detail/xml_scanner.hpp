// Scans the XML of office programs: elements, attributes, text. Not installed.
// Format: XML 1.0 in UTF-8 without document type declarations, which workbooks do not have.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace decid::recording {

/// Scans a text from tag to tag. Names omit their prefix: "row" for "x:row".
class XmlScanner {
 public:
  enum class Tag { open, close, end };

  /// `where` names the file. It and the text must outlive this object.
  XmlScanner(std::string_view text, const std::string& where) : rest_(text), where_(where) {}

  /// Returns the next tag; an empty element opens, then closes. Throws Error for text that is not XML.
  Tag next();
  std::string_view name() const { return name_; }
  /// Returns an attribute of the last opened tag; empty without such an attribute.
  std::string attribute(std::string_view name) const;
  /// Returns the characters between the last two tags.
  const std::string& text() const { return text_; }

 private:
  std::string decoded(std::string_view raw) const;
  std::string_view until(std::string_view mark);
  [[noreturn]] void refuse(const char* what) const;

  std::string_view rest_, name_, attributes_;
  std::string text_;
  bool closes_ = false;  ///< the last opened element has no content
  const std::string& where_;
};

}  // namespace decid::recording
