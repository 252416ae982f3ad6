// The error that bad input from outside raises: a file, a light, a device.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace coppice {

/// Names the item at fault, what is wrong with it, and what the user can do. what() is one line:
/// "ITEM: PROBLEM; REMEDY". Broken preconditions are not errors but asserts (config.hpp).
class InputError : public std::runtime_error {
 public:
  InputError(std::string item, std::string problem, std::string remedy)
      : std::runtime_error(item + ": " + problem + "; " + remedy),
        item_(std::move(item)),
        problem_(std::move(problem)),
        remedy_(std::move(remedy)) {}

  const std::string& item() const { return item_; }
  const std::string& problem() const { return problem_; }
  const std::string& remedy() const { return remedy_; }

 private:
  std::string item_, problem_, remedy_;
};

}  // namespace coppice
