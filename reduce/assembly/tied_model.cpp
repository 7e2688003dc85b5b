// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/tied_model.hpp"

#include <stdexcept>

#include "reduce/assembly/ties/tied_checks.hpp"

namespace flexura::reduce {

const char* name_of(Tie tie) {
  switch (tie) {
    case Tie::rigid:
      return "rigid";
    case Tie::average:
      return "average";
    case Tie::node:
      return "node";
    case Tie::elastic:
      return "elastic";
  }
  return "unknown";
}

namespace {

TiedNumbering checked_numbering(const Part& part, bool may_be_free) {
  TiedNumbering numbering(part);
  if (part.interfaces.empty() && !may_be_free)
    throw std::invalid_argument(
        "the part has no interface: name at least one face, cylinder or node set by which joints can hold "
        "the body");
  check_interfaces(part, numbering, may_be_free);
  check_pieces(part, numbering);
  return numbering;
}

}  // namespace

TiedModel::TiedModel(const Part& part, const AssemblyOptions& options)
    : numbering_(checked_numbering(part, options.may_be_free)),
      pins_(options.shift == 0.0 ? choose_pins(numbering_) : std::vector<int>{}),
      averages_(part, numbering_),
      motions_(numbering_, averages_),
      matrices_(part, numbering_) {
  if (options.team)
    shares_ = assemble_together(part, options, numbering_, matrices_);
  else
    matrices_.assemble(part, options);
}

}  // namespace flexura::reduce
