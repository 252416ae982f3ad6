// Tables of errors as Markdown, printed where COPPICE_TABLES is set in the environment.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <iomanip>
#include <span>
#include <sstream>
#include <string>

namespace lobe_test {

/// Rows of a name or a number, then errors in percent.
class Table {
 public:
  Table(const std::string& title, const std::string& corner, std::span<const double> columns) {
    text_ << title << "\n\n| " << corner << " |";
    for (const double c : columns) text_ << ' ' << c << " |";
    text_ << "\n|";
    for (std::size_t i = 0; i <= columns.size(); ++i) text_ << "---|";
    text_ << '\n';
  }

  template <class Name>
  void start_row(const Name& name) {
    text_ << (started_ ? "\n| " : "| ") << name << " |", started_ = true;
  }

  /// One cell: the shares in percent with two digits, `a / b`.
  void add(std::initializer_list<double> shares) {
    const char* between = " ";
    for (const double share : shares) {
      const double percent = 100 * share;
      text_ << between << std::fixed << std::setprecision(std::abs(percent) < 9.95 ? 1 : 0) << percent;
      between = " / ";
    }
    text_ << std::defaultfloat << std::setprecision(6) << "% |";
  }

  void print() const {
    if (std::getenv("COPPICE_TABLES") != nullptr) MESSAGE("\n" << text_.str());
  }

 private:
  std::ostringstream text_;
  bool started_ = false;
};

}  // namespace lobe_test
