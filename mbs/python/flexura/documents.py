# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Input files from dictionaries.

    flexura.write_toml("pendulum.toml", {"gravity": [0, 0, "-9.81 m/s^2"], "body": {"bar": {"mass": "1 kg"}}})

The programs read files, so that what was computed can be computed again without the script.
"""

import json
import re
from pathlib import Path
from typing import Any, List, Mapping

from .arrays import FilePath


def write_toml(path: FilePath, document: Mapping[str, Any]) -> Path:
    """Writes nested mappings as a TOML file (a mechanism, a part, a study) over what is there, and returns its path.

    Values are texts, numbers (numpy's, too), True and False, lists of them, and mappings; None is left away.
    """
    path = Path(path)
    path.write_text(_table(document, []), encoding="utf-8")
    return path


def _table(table: Mapping[str, Any], name: List[str]) -> str:
    """The keys of a table, then the tables in it, each under its own header."""
    keys, tables = [], []
    for key, value in table.items():
        inner = [*name, _key(key)]
        if value is None:
            continue
        if isinstance(value, Mapping):
            tables.append(f"\n[{'.'.join(inner)}]\n{_table(value, inner)}")
        elif isinstance(value, (list, tuple)) and value and all(isinstance(one, Mapping) for one in value):
            tables += [f"\n[[{'.'.join(inner)}]]\n{_table(one, inner)}" for one in value]
        else:
            keys.append(f"{_key(key)} = {_value(value, '.'.join(inner))}\n")
    return "".join(keys + tables)


def _key(key: object) -> str:
    text = str(key)
    return text if re.fullmatch(r"[A-Za-z0-9_-]+", text) else _text(text)


def _text(text: str) -> str:
    # What JSON escapes TOML reads; of the rest only DEL is not allowed as it stands.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any, place: str) -> str:
    if hasattr(value, "tolist"):  # numpy's arrays and numbers
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_value(one, place) for one in value)}]"
    if isinstance(value, Path):
        return _text(str(value))
    raise TypeError(f"{place}: a {type(value).__name__} has no place in a TOML file; give a text, number, list or dictionary")
