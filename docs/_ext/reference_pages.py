"""Writes the reference: a page for every public name, and a table of each layer.

The pages lie in docs/reference, which git does not keep; names come from `bodyschema.EVERYDAY`,
`BUILDING_BLOCKS` and `PUBLISHED`, so that none can be forgotten.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import bodyschema

LAYERS = {
    "everyday": bodyschema.EVERYDAY,
    "building_blocks": bodyschema.BUILDING_BLOCKS,
    "published": bodyschema.PUBLISHED,
}
PAGE = """# {name}

{layer}; `from bodyschema import {name}`. Written in `bodyschema/{home}.py`.

```{{eval-rst}}
.. {directive}:: bodyschema.{module}.{name}
{options}```
"""
WORDS = {
    "everyday": "Everyday name",
    "building_blocks": "Building block",
    "published": "Published method",
}


def page_name(name: str, thing: Any) -> str:
    """File names differ in more than case: `determinable` makes a `Determinable`."""
    return f"class-{name}" if inspect.isclass(thing) else name


def first_sentence(thing: Any) -> str:
    """What a docstring begins with, on one line."""
    text = " ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split())
    return re.split(r"(?<=[.:])\s", text)[0].rstrip(":.").replace("|", "\\|")


def page(name: str, layer: str, module: str) -> tuple[str, str, str]:
    """(file name, first sentence, text) of the page of one name."""
    thing = getattr(bodyschema, name)
    directive = "autoclass" if inspect.isclass(thing) else "autofunction"
    options = "   :members:\n" if inspect.isclass(thing) else ""
    text = PAGE.format(
        name=name,
        layer=WORDS[layer],
        home=module.replace(".", "/"),
        module=module,
        directive=directive,
        options=options,
    )
    return page_name(name, thing), first_sentence(thing), text


def table(rows: Iterable[tuple[str, str, str]]) -> Iterator[str]:
    """Lines of a table of names, with what each is."""
    yield "| name | is |"
    yield "|---|---|"
    for name, file, sentence in rows:
        yield f"| {{doc}}`{name} </reference/{file}>` | {sentence} |"


def write_if_new(path: Path, text: str) -> None:
    """Leave a file alone that says the same, so that Sphinx does not read it again."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def write_pages(app: Sphinx) -> None:
    """Write every page, and remove those of names that are gone."""
    folder = Path(app.srcdir) / "reference"
    folder.mkdir(exist_ok=True)
    kept: set[str] = set()
    for layer, homes in LAYERS.items():
        rows = []
        for name, module in sorted(homes.items(), key=lambda item: item[0].lower()):
            file, sentence, text = page(name, layer, module)
            write_if_new(folder / f"{file}.md", text)
            rows.append((name, file, sentence))
            kept.add(f"{file}.md")
        listed = "\n".join(file for _, file, _ in rows)
        hidden = f"```{{toctree}}\n:hidden:\n\n{listed}\n```\n"
        text = f"# {WORDS[layer]}s\n\n" + "\n".join(table(rows)) + "\n\n" + hidden
        write_if_new(folder / f"{layer}.md", text)
        kept.add(f"{layer}.md")
    for path in folder.glob("*.md"):
        if path.name not in kept:
            path.unlink()


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True}
