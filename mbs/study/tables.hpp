// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "mbs/study/judge.hpp"

/// A judged study as files.
namespace flexura::study {

/// Everything: choices with overrides, all times, errors of each quantity [to reference, to finest], answers.
nlohmann::json as_json(const StudyFile& study, const Judgement& judgement, const std::string& created_by);

/// One line for each choice, units in the headings.
std::string as_csv(const StudyFile& study, const Judgement& judgement);

/// A section for documentation: table, answers and the picture PICTURE (a file name, or "" for none).
std::string as_markdown(const StudyFile& study, const Judgement& judgement, const std::string& picture);

}  // namespace flexura::study
