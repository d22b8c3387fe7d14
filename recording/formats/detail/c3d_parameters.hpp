// The parameter section of C3D files, and number formats of the format's three processors. Not installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace decid::recording {

/// The size of a block in bytes, the unit of a C3D file's offsets.
inline constexpr std::size_t c3d_block_bytes = 512;

/// Bytes of a C3D file with its processor's byte order and reals. Every read throws Error beyond the last byte.
class C3dBytes {
 public:
  enum class Processor : std::uint8_t { intel = 84, dec = 85, mips = 86 };

  /// `where` names the file. It and the viewed bytes must outlive this object.
  C3dBytes(std::string_view bytes, Processor processor, const std::string& where)
      : bytes_(bytes), processor_(processor), where_(&where) {}

  std::size_t size() const { return bytes_.size(); }
  const std::string& where() const { return *where_; }
  C3dBytes first(std::size_t count) const { return {bytes_.substr(0, count), processor_, *where_}; }

  std::string_view text(std::size_t at, std::size_t count) const;
  std::uint8_t byte(std::size_t at) const { return static_cast<std::uint8_t>(text(at, 1)[0]); }
  int signed_byte(std::size_t at) const { return byte(at) < 128 ? byte(at) : byte(at) - 256; }
  std::uint16_t word(std::size_t at) const;
  /// Returns a word as a signed number.
  std::int16_t integer(std::size_t at) const { return static_cast<std::int16_t>(word(at)); }
  /// Returns a real from four bytes: IEEE 754, or DEC's F_floating, whose reserved operand becomes NaN.
  double real(std::size_t at) const;

 private:
  std::string_view bytes_;
  Processor processor_;
  const std::string* where_;
};

/// Throws the Error for a damaged file. `what`: the end of its sentence.
[[noreturn]] void refuse_damaged_c3d(const std::string& where, const std::string& what);

struct C3dParameter {
  std::vector<double> numbers;     ///< from bytes, signed integers and reals
  std::vector<std::string> texts;  ///< from characters: UTF-8, without padding blanks
};

/// The parameters of a file by group and name, in capitals: "POINT:LABELS".
class C3dParameters {
 public:
  /// Reads the section that begins at byte `begin`. Throws Error for a record that extends beyond the last byte.
  C3dParameters(const C3dBytes& bytes, std::size_t begin);

  /// Returns nullptr if the file has no such parameter.
  const C3dParameter* find(const std::string& name) const;
  /// Returns the first number, or `otherwise` without one.
  double number(const std::string& name, double otherwise) const;
  /// Returns the first number as a count. A negative integer stands for the unsigned integer of its bits.
  double count(const std::string& name, double otherwise) const;
  /// Returns the first text, empty without one.
  std::string text(const std::string& name) const;
  /// Returns all numbers, or texts, of a parameter and of its continuations: SCALE, SCALE2, SCALE3, ...
  std::vector<double> numbers(const std::string& name) const;
  std::vector<std::string> texts(const std::string& name) const;

 private:
  template <class Visit>
  void visit_parts(const std::string& name, const Visit& visit) const;

  std::map<std::string, C3dParameter> parameters_;
};

}  // namespace decid::recording
