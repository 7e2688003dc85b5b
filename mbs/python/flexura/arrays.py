# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays that know what they are, and how Flexura's files give them."""

import os
from contextlib import contextmanager
from os import PathLike
from typing import Any, Iterator, Optional, Union

import h5py
import numpy as np
import numpy.typing as npt

FilePath = Union[str, "PathLike[str]"]


class Array(np.ndarray):  # type: ignore[type-arg]  # of any shape and kind of number
    """A numpy array with a name, a unit (SI, "rad/s") and a sentence that says what it is.

    Slices keep all three.  What arithmetic gives is an array whose name and unit are empty: nobody has said what
    they are.
    """

    name = ""
    unit = ""
    doc = ""

    def __new__(cls, values: npt.ArrayLike, name: str = "", unit: str = "", doc: str = "") -> "Array":
        array = np.asarray(values).view(cls)
        array.name, array.unit, array.doc = name, unit, doc
        return array

    def __array_finalize__(self, source: Any) -> None:
        # Views of an Array are its slices and transposes.
        if isinstance(source, Array) and self.base is not None:
            self.name, self.unit, self.doc = source.name, source.unit, source.doc

    def __array_wrap__(self, values: Any, context: Any = None, return_scalar: bool = False) -> Any:
        # Results of ufuncs and of functions like mean().
        plain = np.asarray(values)
        return plain[()] if plain.ndim == 0 else plain.view(Array)._anonymous()

    def _anonymous(self) -> "Array":
        self.name = self.unit = self.doc = ""
        return self

    @property
    def label(self) -> str:
        """For an axis: "main.speed [rad/s]"."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@contextmanager
def open_file(path: FilePath, kind: str) -> Iterator[h5py.File]:
    """One of Flexura's HDF5 files, `kind` "superelement" or "results"; HDF5 checks its checksums.

    Raises OSError for a file that is damaged and ValueError for one of another kind or of a later version.
    """
    with _open(path) as file:
        if attribute(file, "format") != f"flexura {kind}":
            other = {"flexura superelement": "; read_superelement reads it", "flexura results": "; read_results reads it"}
            found = attribute(file, "format", "unknown")
            raise ValueError(f"{path} is no {kind} file (its format is {found!r}){other.get(found, '')}")
        newest = 2 if kind == "superelement" else 1
        if int(attribute(file, "version", 0)) > newest:
            raise ValueError(f"{path} has version {attribute(file, 'version')}; this package reads up to {newest}")
        yield file


def _open(path: FilePath) -> h5py.File:
    try:
        return h5py.File(path, "r")
    except OSError as refused:
        # A run that goes on, or was killed, has left its mark in the file.  What is there is consistent.
        try:
            return h5py.File(path, "r", swmr=True)
        except OSError:
            if not os.path.exists(path):
                raise FileNotFoundError(f"{path}: there is no such file") from None
            if not h5py.is_hdf5(path):
                raise OSError(f"{path}: is no HDF5 file, as superelements and results are") from None
            raise OSError(f"{path}: {refused}") from None


def read_array(dataset: h5py.Dataset, name: Optional[str] = None) -> Array:
    """A dataset of a Flexura file with its unit and doc; a row-major array as it is stored."""
    return Array(dataset[()], name or dataset.name.rsplit("/", 1)[-1], _text(dataset.attrs.get("unit", "")),
                 _text(dataset.attrs.get("doc", "")))


def read_text(dataset: h5py.Dataset) -> str:
    """Texts are stored as bytes in UTF-8."""
    return bytes(dataset[()]).decode("utf-8")


def _text(value: Union[bytes, str]) -> str:
    text = value.decode("utf-8") if isinstance(value, bytes) else str(value)
    return text.rstrip("\0")


def attribute(group: h5py.Group, name: str, fallback: Any = "") -> Any:
    """An attribute as text or number."""
    value = group.attrs.get(name, fallback)
    return _text(value) if isinstance(value, (bytes, str)) else value
