#!/usr/bin/env bash
# extremes_page.sh LOG PAGE.json: gathers the Markdown tables that the tests at the extremes printed (ctest --verbose
# > LOG) into the JSON of a report; "flexura report PAGE.json" makes the page.
set -euo pipefail
awk '
function quoted(s) { gsub(/\\/, "\\\\", s); gsub(/"/, "\\\"", s); gsub(/\t/, " ", s); gsub(/[\001-\037]/, "", s); return "\"" s "\"" }
function trimmed(s) { sub(/^[ ]+/, "", s); sub(/[ ]+$/, "", s); gsub(/\*\*|`/, "", s); return s }
function is_number(s) { return s ~ /^[-+]?[0-9]+(\.[0-9]*)?([eE][-+]?[0-9]+)?$/ }
function end_table() { if (rows != "") { blocks = blocks (blocks == "" ? "" : ", ") "{\"table\": {\"columns\": [" columns "], \"rows\": [" rows "]}}" } columns = rows = "" }
function end_text() { if (text != "") { blocks = blocks (blocks == "" ? "" : ", ") "{\"text\": " quoted(text) "}" } text = "" }
function end_section() {
  end_text(); end_table()
  if (title != "" && blocks != "") { sections = sections (sections == "" ? "" : ",\n") "{\"title\": " quoted(title) ", \"blocks\": [" blocks "]}"; n++ }
  blocks = ""
}
{
  sub(/\r$/, "")
  if (!sub(/^[0-9]+: ?/, "")) next             # what ctest itself says
  if ($0 ~ /^\[|^Note: |^Running main|^[0-9]+\/[0-9]+ /) next  # what GoogleTest says
}
/^#+ / { end_section(); title = $0; sub(/^#+ /, "", title); title = trimmed(title); next }
/^\|[-:| ]+\|$/ { next }
/^\|/ {
  end_text()
  count = split($0, cell, "|"); line = ""
  for (i = 2; i < count; i++) { c = trimmed(cell[i]); line = line (i == 2 ? "" : ", ") (columns != "" && is_number(c) ? c + 0 : quoted(c)) }
  if (columns == "") { columns = line; width = count } else if (count == width) rows = rows (rows == "" ? "" : ", ") "[" line "]"
  next
}
{ end_table(); if ($0 ~ /[A-Za-z]/ && title != "") text = text (text == "" ? "" : " ") trimmed($0) }
END {
  end_section()
  if (n == 0) { print "no table in the log: did the tests at the extremes run with --verbose?" > "/dev/stderr"; exit 1 }
  printf "{\"title\": \"Flexura at the extremes\", \"summary\": %s, \"sections\": [%s]}\n", quoted("What the tests at the extremes measured: how far results hold, and to what accuracy."), sections
}' "$1" >"$2.part"
mv "$2.part" "$2"
