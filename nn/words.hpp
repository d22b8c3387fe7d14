// The words of a layer's line, read one by one with errors that name the line. A layer's parser reads them.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace decid::nn {

class Words {
 public:
  /// number: of the line in its architecture, from 1, for errors; 0: none. Throws Error if the line is longer than any
  /// layer, whose errors quote it.
  explicit Words(const std::string& line, int number = 0);

  /// Returns the first word, which names the layer.
  const std::string& name() const { return words_.front(); }
  bool done() const { return next_ == words_.size(); }
  /// Throws Error if words are left over.
  void finish() const;
  /// Takes the next word. Throws Error if there is none.
  std::string take();
  /// Takes the next word if it is `word`.
  bool take_if(const std::string& word);
  /// Takes a whole number in [low, high].
  int take_int(int low, int high) { return to_int(take(), low, high); }
  /// Takes "3" or "3x5": rows and columns, each in [low, high].
  std::pair<int, int> take_pair(int low, int high);
  /// Returns "3x5", as take_pair() takes it.
  static std::string pair(int rows, int columns) { return std::to_string(rows) + "x" + std::to_string(columns); }
  /// Takes a number in [low, high].
  double take_number(double low, double high);
  /// Throws Error of this line, with the form of such a line as the remedy.
  [[noreturn]] void fail(const std::string& problem) const;
  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const;
  /// Throws Error of a line whose first word names no layer, with all forms.
  [[noreturn]] void fail_unknown() const;
  /// Fails if `count` of `values` are more than max_values.
  void limit(long long count, const std::string& values) const;

 private:
  int to_int(const std::string& word, int low, int high) const;

  std::string line_;
  int number_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

}  // namespace decid::nn
