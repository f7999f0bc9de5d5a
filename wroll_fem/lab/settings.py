"""Settings of laboratory evaluations: base class, and reading from a YAML file, from `--set` and from Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import yaml
from pydantic import Field, ValidationError

from wroll_fem.case.base import Section, Switch
from wroll_fem.case.loader import locate, read_yaml
from wroll_fem.case.messages import input_error
from wroll_fem.case.overrides import overridden, override_texts


class LabSettings(Section):
    """Settings of an evaluation, immutable and in SI units; unknown keys are refused.

    Attributes
    ----------
    PATHS
        Dotted keys with paths. A relative path in a settings file is taken relative to this file.
    """

    PATHS: ClassVar[tuple[str, ...]] = ()

    figures: Switch = Field(True, description="whether figures are drawn")

    def yaml(self) -> str:
        """All values with defaults as YAML text; reading it gives equal settings."""
        data = self.model_dump(mode="json")
        return str(yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=120))


def read_settings(
    model: type[LabSettings],
    file: str | Path | None = None,
    overrides: Sequence[str] = (),
    values: Mapping[str, Any] | None = None,
) -> LabSettings:
    """Settings of a kind from a file, overrides and values; the later ones win.

    Parameters
    ----------
    model
        Model of the settings.
    file
        YAML file with some of the keys; None for the defaults.
    overrides
        "dotted.key=value" texts, the value in YAML.
    values
        Keys and values, as from Python; dotted keys are allowed.

    Raises
    ------
    InputError
        If a key or value is wrong; the message names file, key, value and remedy.
    """
    path = None if file is None else Path(file)
    data = {} if path is None else read_yaml(path, "settings file")
    if path is not None:
        for key in model.PATHS:
            *outer, last = key.split(".")
            here: Any = data
            for part in outer:
                here = here.get(part) if isinstance(here, dict) else None
            if isinstance(here, dict) and isinstance(here.get(last), str):
                here[last] = str((path.parent / here[last]).resolve())
    source = None if path is None else str(path)
    merged, (keys, _) = overridden(data, [*overrides, *override_texts(dict(values or {}))], source)
    try:
        return model.model_validate(merged)
    except ValidationError as error:
        typed = [key for key in keys if key.split(".")[0] not in (values or {})]
        found = input_error(error.errors(include_url=False), model, file=source, overrides=typed)
        if path is not None:
            locate(found, path)
        raise found from None
