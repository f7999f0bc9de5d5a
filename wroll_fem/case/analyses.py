"""Registry of the analyses: every name that `analysis` may have in a case file, with the module that runs it.

The table stands in this room because case classes and schema follow from it. It holds the modules as text, and nothing
here imports them; `analyses.registry` does when an analysis is asked for.
"""

from __future__ import annotations

MODULES: dict[str, str] = {
    "sweep": "wroll_fem.analyses.sweep",
    "dwell": "wroll_fem.analyses.dwell",
    "harmonic": "wroll_fem.analyses.harmonic",
    "backbone": "wroll_fem.analyses.backbone",
    "modal": "wroll_fem.analyses.modal",
    "modal_transient": "wroll_fem.analyses.modal_transient",
    "preload": "wroll_fem.analyses.preload",
    "buckling": "wroll_fem.analyses.buckling",
    "winding": "wroll_fem.analyses.winding",
    "design_map": "wroll_fem.analyses.design_map",
    "two_dof": "wroll_fem.analyses.two_dof",
}
"""Name in the case file -> module that defines its `ANALYSIS`."""
