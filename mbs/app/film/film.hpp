// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

/// Films of pages, from the command line.
namespace flexura::app {

struct FilmOptions {
  std::string size = "1280x720", view = "iso",
              color;     ///< color: displacement, stress, bodies; empty: the page's choice
  double seconds = 0.0;  ///< 0: the page's choice
  int fps = 25;
};

/// Refuses (std::invalid_argument, naming the option) what cannot be filmed, before anything is computed.
void check_film(const std::filesystem::path& film, const FilmOptions& options);

/// The motion of a page as a film, .mp4, .webm or .gif by the name's ending, drawn frame by frame in a browser of this machine.
/// Throws std::runtime_error where there is none, or it does not write the format.
void write_film(const std::filesystem::path& film, const std::filesystem::path& html,
                const FilmOptions& options);

}  // namespace flexura::app
