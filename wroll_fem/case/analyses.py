"""Registry of the analyses: every value of the key `analysis`, with the module that runs the analysis.

The table is in this room because the case classes and the schema are derived from it. The modules are named as text
and are not imported here. `analyses.registry` imports the module of an analysis when it is needed.
"""

from __future__ import annotations

MODULES: dict[str, str] = {
    "sweep": "wroll_fem.analyses.sweep",
    "dwell": "wroll_fem.analyses.dwell",
    "random": "wroll_fem.analyses.random",
    "shock": "wroll_fem.analyses.shock",
    "harmonic": "wroll_fem.analyses.harmonic",
    "backbone": "wroll_fem.analyses.backbone",
    "random_response": "wroll_fem.analyses.random_response",
    "modal": "wroll_fem.analyses.modal",
    "modal_transient": "wroll_fem.analyses.modal_transient",
    "slip_damping": "wroll_fem.analyses.slip_damping",
    "preload": "wroll_fem.analyses.preload",
    "buckling": "wroll_fem.analyses.buckling",
    "winding": "wroll_fem.analyses.winding",
    "design_map": "wroll_fem.analyses.design_map",
    "sizing": "wroll_fem.analyses.sizing",
    "two_dof": "wroll_fem.analyses.two_dof",
}
"""Name of the analysis -> module that defines its `ANALYSIS`."""
