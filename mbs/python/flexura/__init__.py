# Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
"""Flexible bodies from CAD in multibody simulation, from Python.

    import flexura
    se = flexura.reduce("conrod.toml", "conrod.se.h5")      # a Superelement
    results = flexura.simulate("engine.toml", "engine.h5")  # Results
    results["flexible"]["main.speed"]                       # an array that knows its name and unit

Everything is SI.  README.md has a worked example.
"""

from .arrays import Array
from .documents import write_toml
from .programs import FlexuraError, Page, eigen, modes, page, program, reduce, simulate, statics
from .results import Body, Results, Run, read_results
from .studies import Choice, Study, read_study, study
from .superelement import Interface, Modes, SectionForces, Superelement, read_superelement

__all__ = [
    "Array", "Body", "Choice", "FlexuraError", "Interface", "Modes", "Page", "Results", "Run", "SectionForces", "Study",
    "Superelement", "eigen", "modes", "page", "program", "read_results", "read_study", "read_superelement", "reduce", "simulate",
    "statics", "study", "write_toml",
]
__version__ = "0.2.0"
