// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>

#include "mbs/bodies/flexible_body.hpp"
#include "mbs/bodies/modal_basis.hpp"

namespace flexura::mbs {

/// A superelement as a flexible body in modal coordinates.  Its interfaces are nodes that markers can sit on.
class ModalBody {
 public:
  /// Throws std::runtime_error for a file that is no whole superelement, std::invalid_argument where no body can be
  /// made of it (modal_data()).
  static ModalBody read(const std::filesystem::path& file, const BasisOptions& options = {});
  explicit ModalBody(const superelement::Superelement& se, const BasisOptions& options = {});

  const std::shared_ptr<const FlexibleBody>& body() const { return body_; }
  const BasisReport& report() const { return report_; }  ///< modes kept, their frequencies [Hz]

 private:
  BasisReport report_;
  std::shared_ptr<const FlexibleBody> body_;
};

}  // namespace flexura::mbs
