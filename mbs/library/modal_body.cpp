// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/library/modal_body.hpp"

#include "mbs/superelement/file.hpp"

namespace flexura::mbs {

ModalBody ModalBody::read(const std::filesystem::path& file, const BasisOptions& options) {
  return ModalBody(superelement::read(file, {.stiffening = options.stiffening}), options);
}

ModalBody::ModalBody(const superelement::Superelement& se, const BasisOptions& options)
    : body_(std::make_shared<FlexibleBody>(modal_data(se, options, &report_))) {}

}  // namespace flexura::mbs
