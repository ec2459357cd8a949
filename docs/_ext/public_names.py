"""Warns of every public name of bodyschema that no page documents, so that none is forgotten."""

from __future__ import annotations

from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util import logging

import bodyschema

logger = logging.getLogger(__name__)


def _check(app: Sphinx, env: BuildEnvironment) -> None:
    documented = env.domains.python_domain.objects
    for name in bodyschema.__all__:
        thing = getattr(bodyschema, name)
        if f"{thing.__module__}.{thing.__qualname__}" not in documented:
            logger.warning("bodyschema.%s is public, but no page documents it", name)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("env-check-consistency", _check)
    return {"parallel_read_safe": True}
